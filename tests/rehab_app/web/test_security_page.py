"""The threat model names only measures that are tested: every test that it names exists."""

from __future__ import annotations

import re
from pathlib import Path

TESTS = Path(__file__).parents[2]
PAGE = TESTS.parent / "docs" / "security.md"


def test_every_test_of_the_threat_model_exists():
    named, last = 0, ""
    for file, function in re.findall(
        r"`((?:[\w/]+\.py)?)(?:::(test_\w+))?`", PAGE.read_text(encoding="utf-8")
    ):
        if not file.startswith("tests/") and not file.startswith("test_") and not (function and not file):
            continue
        last = file or last
        path = TESTS.parent / last if last.startswith("tests/") else Path(__file__).parent / last
        assert path.is_file(), last
        if function:
            assert f"def {function}(" in path.read_text(encoding="utf-8"), f"{last}::{function}"
            named += 1
    assert named > 20
