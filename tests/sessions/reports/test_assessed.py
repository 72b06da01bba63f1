"""Guided assessments in the progress report: judged like any number; tone is no grade."""

from __future__ import annotations

import math
from typing import Any

import pytest

from sessions.reports.assessed import Ends, Tone, ranges_as_pasts, tone_words
from sessions.reports.progress import line
from sessions.reports.progress_formats import render_progress
from sessions.reports.progress_tables import Judgements, assessed_tables, judged_tables

from .pasts import DAY_NS, kept, past, progress

UTC_NS = 1_790_000_000_000_000_000


def assessed(*found: tuple[float, float], device: str = "glove", at_end: bool = False) -> dict[str, Any]:
    """Assessments on successive days: smallest active and passive angle of the index PIP, degrees."""
    pairs = [
        ranges_as_pasts(
            f"s{number}",
            UTC_NS + number * DAY_NS,
            "right",
            device,
            [Ends("index_pip", rad(active, 80.0), rad(passive, 90.0), at_end)],
        )
        for number, (active, passive) in enumerate(found)
    ]
    return {"active": tuple(one for one, _ in pairs), "passive": tuple(other for _, other in pairs)}


def rad(*degrees: float) -> Any:
    return tuple(math.radians(value) for value in degrees)


def of(view: Any, name: str) -> Any:
    found = line(view, name, "index_pip")
    assert found is not None
    return found


def test_lag_and_deficit_are_told_apart_and_judged() -> None:
    made = assessed((35.0, 10.0), (30.0, 10.0), (22.0, 9.0))
    lag = of(progress(*made["active"]), "extension_lag")
    assert [math.degrees(one.value) for one in (lag.baseline, lag.last, lag.now)] == pytest.approx(
        [25, 20, 13]
    )
    assert lag.change.verdict == "real"  # 12 degrees, above the 5 published
    deficit = of(progress(*made["passive"]), "contracture")
    assert math.degrees(deficit.now.value) == pytest.approx(9.0)
    assert deficit.change.verdict == "below MDC"
    share = of(progress(*made["passive"]), "range_share")
    assert share.now.value == pytest.approx(81.0 / 100.0)
    assert share.change.verdict == "not measurable"


def test_another_device_is_not_compared_and_its_end_is_told() -> None:
    one, other = assessed((35.0, 10.0), device="glove"), assessed((5.0, 0.0), device="arm", at_end=True)
    found = of(progress(*one["active"], *other["active"]), "extension_lag")
    assert found.change.verdict == "not measurable"
    assert "encoders of glove, then by encoders of arm" in found.change.why
    assert of(progress(*other["passive"]), "range_of_motion").now.status == "flagged: at least, device limit"
    assert of(progress(*other["passive"]), "contracture").now.status == "flagged: at most, device limit"


def test_what_was_not_measured_gives_no_number() -> None:
    active, passive = ranges_as_pasts(
        "s", UTC_NS, "right", "glove", [Ends("index_pip", rad(math.nan, math.nan), rad(10.0, 90.0), False)]
    )
    assert math.isnan(active.value("extension_lag", "index_pip"))
    assert math.degrees(passive.value("contracture", "index_pip")) == pytest.approx(10.0)
    nothing = ranges_as_pasts(
        "s", UTC_NS, "right", "glove", [Ends("wrist", rad(0.0, 1.0), rad(math.nan, 1.0), False)]
    )
    assert math.isnan(nothing[0].value("extension_lag", "wrist"))


def test_the_report_holds_ranges_tone_and_what_nobody_published() -> None:
    tones = tuple(
        Tone(
            UTC_NS + n * DAY_NS,
            "glove",
            "index_pip",
            rad(30.0, 60.0, 120.0),
            (0.1, 0.2, 0.4),
            rise,
            (rise - 0.01, rise + 0.01),
        )
        for n, rise in enumerate((0.20, 0.30))
    )
    found = progress(
        past(0), past(1), past(2), tones=tones, **assessed((35.0, 10.0), (22.0, 9.0), (21.0, 9.0))
    )
    page = render_progress(found, "html").decode()
    for words in (
        "Range assessments",
        "Extension lag",
        "Passive extension deficit",
        "no Modified Ashworth grade",
    ):
        assert words in page
    assert "For numbers measured by a robot or a camera none is published" in page
    assert "repeatability unknown" in page
    tables = assessed_tables(found, Judgements())
    assert any("the robot moved the hand" in table.title for table in tables)
    assert any("the patient moved" in table.title for table in tables)
    assert tone_words(()) is None
    words = tone_words(tones[:1])
    assert words is not None
    assert words.rows[0][-1] == "measured once"


def test_modes_stand_in_tables_of_their_own() -> None:
    passive: dict[str, Any] = {"modes": ("passive",), "conditions": "stiffness 0.90 Nm/rad, passive mode"}
    found = progress(past(0, **passive), past(1), past(2, pip_deg=70.0, **passive), past(3, pip_deg=60.0))
    tables = [one for one in judged_tables(found, Judgements()) if one.title.startswith("Range of motion")]
    assert ["active-assisted mode" in table.title for table in tables] == [True, False]
    assert "passive mode" in tables[1].title
    assert tables[0].rows[0].cells[0].text == "40.0°" or "40" in tables[0].rows[0].cells[0].text
    assert all(len(table.columns) == len(tables[0].columns) for table in tables)
    assert kept("sparc", "index", None).value is None
