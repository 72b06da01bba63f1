"""Hazard 10: tendon repair, fracture, CRPS. Every template, mode and date; locks open by date or by act."""

from __future__ import annotations

from datetime import date, timedelta

import pytest

from rehab_app.errors import Refused
from rehab_app.services.diagnosis import allow, check_mode, template
from rehab_app.services.diagnosis_templates import TEMPLATES
from robot_iface.types import MODES
from sessions.catalogue import ClinicalRecord, ModeUnlock

EVENT = date(2026, 2, 25)  # the days that follow cross a month's end and a change of summer time

# First day of each mode, stated once more so that no table changes by accident; None: by act only.
FIRST_DAY: dict[str, dict[str, int | None]] = {
    "none": {"passive": 0, "assistive": 0, "transparent": 0, "resistive": 0},
    "stroke": {"passive": 1, "assistive": 1, "transparent": 1, "resistive": 14},
    "flexor-tendon-repair": {"passive": 3, "assistive": 42, "transparent": 42, "resistive": 56},
    "extensor-tendon-repair": {"passive": 42, "assistive": 42, "transparent": 28, "resistive": 56},
    "fracture": {"passive": 42, "assistive": 28, "transparent": 21, "resistive": 56},
    "rheumatoid-arthritis": {"passive": 0, "assistive": 0, "transparent": 0, "resistive": None},
    "crps": {"passive": None, "assistive": 0, "transparent": 0, "resistive": None},
    "nerve-lesion": {"passive": 21, "assistive": 21, "transparent": 21, "resistive": 56},
    "burn": {"passive": 7, "assistive": 7, "transparent": 5, "resistive": 42},
}
CASES = [(key, mode, day) for key, row in FIRST_DAY.items() for mode, day in row.items()]


def record(key: str, event_date: str) -> ClinicalRecord:
    return ClinicalRecord(patient="P-0001", diagnosis=key, event_date=event_date, by="anna")


def test_the_matrix_is_whole() -> None:
    assert set(FIRST_DAY) == {one.key for one in TEMPLATES}
    assert {mode for _, mode, _ in CASES} == set(MODES)
    assert len(CASES) == 9 * 4


@pytest.mark.parametrize(("key", "mode", "first_day"), CASES)
@pytest.mark.parametrize("day", [0, 1, 2, 3, 4, 5, 7, 13, 14, 20, 21, 27, 28, 41, 42, 55, 56, 400])
def test_a_mode_opens_on_its_day_and_not_before(key: str, mode: str, first_day: int | None, day: int) -> None:
    met = allow(template(key), mode, EVENT.isoformat(), EVENT + timedelta(days=day))
    if first_day is not None and day >= first_day:
        assert met is None
        return
    assert isinstance(met, Refused)
    assert mode in met.thing
    assert "unlock" in met.remedy
    if first_day is not None:
        assert (EVENT + timedelta(days=first_day)).isoformat() in met.bound


@pytest.mark.parametrize(("key", "mode", "first_day"), CASES)
def test_without_its_date_a_dated_lock_stays_closed(key: str, mode: str, first_day: int | None) -> None:
    met = allow(template(key), mode, "", EVENT + timedelta(days=4000))
    assert (met is None) == (first_day == 0)


@pytest.mark.parametrize(("key", "mode", "first_day"), [case for case in CASES if case[2] != 0])
def test_only_an_act_for_this_very_event_opens_a_lock(key: str, mode: str, first_day: int | None) -> None:
    mine = record(key, EVENT.isoformat())

    def act(**changes: object) -> ModeUnlock:
        said: dict[str, object] = {
            "patient": "P-0001",
            "mode": mode,
            "diagnosis": key,
            "event_date": mine.event_date,
            "unlocked": True,
            "reason": "stable",
            "by": "anna",
        }
        return ModeUnlock(**{**said, **changes})

    assert check_mode(mine, (act(),), mode, EVENT) == (act(),)
    other_mode = next(one for one in MODES if one != mode)
    for useless in (
        (),
        (act(mode=other_mode),),
        (act(diagnosis="none"),),
        (act(event_date="2020-01-01"),),
        (act(unlocked=False), act()),
    ):
        with pytest.raises(Refused, match=mode):
            check_mode(mine, useless, mode, EVENT)
