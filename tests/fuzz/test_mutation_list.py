"""The list of surviving mutants speaks of lines that exist."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).resolve().parents[2]
TABLE = (REPOSITORY / "docs" / "mutation.md").read_text().split("## Survivors", 1)[1]
ROWS = re.findall(r"^\| `([^`]+)` \| `([^`]+)` \| ([^|]+) \| ([^|]+) \|$", TABLE, re.MULTILINE)


def test_every_row_is_read() -> None:
    lines = [line for line in TABLE.splitlines() if line.startswith("| `")]
    assert len(lines) == len(ROWS) > 5


@pytest.mark.parametrize(("source", "line", "change", "reason"), ROWS, ids=[f"{r[0]}: {r[1]}" for r in ROWS])
def test_the_line_still_exists_and_a_reason_is_given(
    source: str, line: str, change: str, reason: str
) -> None:
    text = (REPOSITORY / "robot_iface" / "safety" / source).read_text()
    assert line in [stripped.strip() for stripped in text.splitlines()]
    assert len(change) > 3
    assert len(reason) > 20
