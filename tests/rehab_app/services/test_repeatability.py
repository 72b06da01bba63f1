"""Repeatability of a set-up is estimated from enough recordings or refused, and kept."""

from __future__ import annotations

from pathlib import Path

import pytest

from rehab_app.access import CONSOLE
from rehab_app.bootstrap import open_clinic
from rehab_app.errors import Refused


def test_too_few_or_too_many_recordings_are_refused_and_nothing_is_kept(tmp_path: Path) -> None:
    with open_clinic(tmp_path / "clinic") as clinic:
        assert clinic.repeatability.kept() == ()
        with pytest.raises(Refused, match="at least 6"):
            clinic.repeatability.estimate(CONSOLE, ["a.mcap", "b.mcap"])
        for count in (5, 51):
            with pytest.raises(Refused, match=r"at (least 6|most 50)"):
                clinic.repeatability.estimate_virtual(CONSOLE, count, "open_close", str)
        assert clinic.repeatability.kept() == ()
