"""The hazard log itself: what it calls covered has a test, and every test has its row."""

from __future__ import annotations

import re
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parents[2]
LOG = (REPOSITORY / "docs" / "hazards.md").read_text()
ROWS = [
    [cell.strip() for cell in line.strip()[1:-1].split("|")]
    for line in LOG.splitlines()
    if re.match(r"\| \d+ ", line)
]
STATES = {"covered", "partly", "not yet"}


def test_the_log_has_the_clinical_hazards_in_order() -> None:
    assert [int(row[0]) for row in ROWS][:15] == list(range(1, 16))
    assert {row[3] for row in ROWS} <= STATES


def test_every_row_that_claims_a_measure_names_a_test_that_exists() -> None:
    for number, _, measure, state, tests in ROWS:
        named = re.findall(r"`([^`]+\.py)`", tests)
        if state == "not yet":
            assert not named, f"hazard {number} is marked not yet, but names a test"
            continue
        assert measure, f"hazard {number} has no measure"
        assert named, f"hazard {number} is marked {state} without a test"
        for name in named:
            path = REPOSITORY / "tests" / "hazards" / name
            assert path.is_file(), f"hazard {number}: {name} is missing"
            assert "def test_" in path.read_text()


def test_every_test_of_a_hazard_is_in_the_log() -> None:
    files = {path.name for path in (REPOSITORY / "tests" / "hazards").glob("test_*.py")} - {"test_log.py"}
    named = {name for row in ROWS for name in re.findall(r"`([^`]+\.py)`", row[4])}
    assert files <= named


def test_the_log_names_its_standards_and_says_what_the_product_is_not() -> None:
    for standard in ("IEC 80601-2-78", "ISO 14971", "IEC 62304", "IEC 62366-1", "IEC 60204-1"):
        assert standard in LOG
    assert "not a certified medical device" in LOG
