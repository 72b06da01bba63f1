"""The hazard log itself: the build fails where a hazard has no measure, no test, or a test has no hazard."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).resolve().parents[2]
LOG = (REPOSITORY / "docs" / "hazards.md").read_text()
RULES = (REPOSITORY / "docs" / "clinical.md").read_text()
CLINICAL = 15
"""The first rows are the hazards that clinicians named; what was found later follows."""


def rows_of(text: str) -> list[list[str]]:
    """Cells of every numbered row of a table."""
    lines = (line.strip() for line in text.splitlines() if re.match(r"\| \d+ ", line))
    return [[cell.strip() for cell in line[1:-1].split("|")] for line in lines]


def path_of(name: str) -> Path:
    """A test's file: a bare name lies with the hazards, any other is given from the repository on."""
    return REPOSITORY / name if "/" in name else REPOSITORY / "tests" / "hazards" / name


def named_in(cell: str) -> list[str]:
    return re.findall(r"`([^`]+\.py)`", cell)


def complaints(row: list[str]) -> list[str]:
    """Everything that is wrong with one row."""
    if len(row) != 5:
        return [f"hazard {row[0]} has {len(row)} cells"]
    number, hazard, measure, state, shown = row
    named = named_in(shown)
    own = [name for name in named if "/" not in name]
    wrong = [f"{name} is missing" for name in named if not path_of(name).is_file()]
    wrong += [f"{name} has no test" for name in named if path_of(name).is_file() and not has_test(name)]
    found = (
        ("→" not in hazard, "does not say what follows from it"),
        (not measure, "has no measure"),
        (state not in ("covered", "partly"), f"is {state}"),
        (not own, "has no test in tests/hazards"),
        (state == "partly" and "Missing:" not in measure, "is covered partly without a word on the rest"),
        (state == "covered" and "issing" in measure, "is called covered, but something is missing"),
    )
    return [f"hazard {number} {words}" for holds, words in found if holds] + wrong


def has_test(name: str) -> bool:
    return "def test_" in path_of(name).read_text()


def test_every_hazard_is_covered_by_a_measure_and_a_test() -> None:
    assert [wrong for row in rows_of(LOG) for wrong in complaints(row)] == []


def test_the_log_has_the_clinical_hazards_and_counts_on() -> None:
    numbers = [int(row[0]) for row in rows_of(LOG)]
    assert numbers == list(range(1, len(numbers) + 1))
    assert len(numbers) > CLINICAL


def test_every_test_of_a_hazard_is_in_the_log() -> None:
    files = {path.name for path in (REPOSITORY / "tests" / "hazards").glob("test_*.py")} - {"test_log.py"}
    named = {name for row in rows_of(LOG) for name in named_in(row[4])}
    assert files <= named, f"no hazard names {files - named}"


@pytest.mark.parametrize(
    ("row", "words"),
    [
        ("| 1 | a → b | it is held | not yet | `test_stop.py` |", "is not yet"),
        ("| 1 | a → b | it is held | covered | |", "has no test in tests/hazards"),
        ("| 1 | a → b | it is held | covered | `test_nothing.py` |", "test_nothing.py is missing"),
        ("| 1 | a → b | it is held | covered | `conftest.py` |", "conftest.py has no test"),
        ("| 1 | a → b | it is held | covered | `tests/rehab_app/web/test_stop.py` |", "has no test in tests"),
        ("| 1 | a → b | it is held | partly | `test_stop.py` |", "without a word on the rest"),
        ("| 1 | a → b | b. Missing: c | covered | `test_stop.py` |", "something is missing"),
        ("| 1 | a → b | | covered | `test_stop.py` |", "has no measure"),
        ("| 1 | a | it is held | covered | `test_stop.py` |", "does not say what follows"),
        ("| 1 | a → b | it is held | covered |", "has 4 cells"),
    ],
)
def test_a_row_that_claims_too_much_is_found(row: str, words: str) -> None:
    (wrong,) = (complaints(one) for one in rows_of(row))
    assert any(words in one for one in wrong), wrong


def test_every_clinical_rule_says_where_it_is_held_and_shown() -> None:
    rules = rows_of(RULES)
    assert len(rules) >= 20
    for number, rule, place, shown, state in rules:
        for name in re.findall(r"`([^`]+\.(?:py|js|j2))`", place + shown):
            assert (REPOSITORY / name).is_file(), f"rule {number}: {name} is missing"
        assert rule
        if state == "held":
            assert place, f"rule {number} is held nowhere"
            assert named_in(shown), f"rule {number} is shown by nothing"
        else:
            assert state.startswith(("in part: ", "not held: ")), f"rule {number} is {state}"


def test_the_log_names_its_standards_and_says_what_the_product_is_not() -> None:
    for standard in ("IEC 80601-2-78", "ISO 14971", "IEC 62304", "IEC 62366-1", "IEC 60204-1"):
        assert standard in LOG
    assert "not a certified medical device" in LOG
