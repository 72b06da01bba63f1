"""What is compared with what, what may be said of it, and that nobody is credited for nothing."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sessions.metrics import measure
from sessions.reports.past import Trial, past_from_json, past_of, past_to_json
from sessions.reports.progress import LeftOut, Score, leading_line, line
from sessions.reports.progress_formats import PROGRESS_FORMATS, render_progress
from sessions.reports.progress_sentences import progress_sentences
from sessions.reports.verdict import change, comparable

from .pasts import kept, past, progress

ROM = ("range_of_motion", "index_pip")


def nothing_known(name: str, subject: str, source: str) -> float | None:
    return None


def told(found: Any) -> str:
    return " ".join(progress_sentences(found, leading_line(found)))


@pytest.mark.parametrize(
    ("mdc_deg", "gain_deg", "verdict"),
    [(5.5, 5.0, "below MDC"), (5.5, 6.0, "real"), (11.1, 10.0, "below MDC")],
)
def test_a_change_is_real_only_beyond_what_this_set_up_can_tell(
    mdc_deg: float, gain_deg: float, verdict: str
) -> None:
    found = progress(
        past(0),
        past(1, pip_deg=40.0 + gain_deg),
        bounds=(("range_of_motion", "", "encoder", math.radians(mdc_deg)),),
    )
    shown = line(found, *ROM)
    assert shown is not None
    assert shown.change.verdict == verdict
    assert math.degrees(shown.change.bound) == pytest.approx(mdc_deg)
    assert math.degrees(shown.change.difference) == pytest.approx(gain_deg)


def test_without_a_measured_mdc_the_published_one_holds_and_a_bare_camera_sees_no_ten_degrees() -> None:
    assert change(past(0), past(1, pip_deg=46.0), *ROM, nothing_known).verdict == "real"
    assert change(past(0), past(1, pip_deg=44.0), *ROM, nothing_known).verdict == "below MDC"
    seen = [
        replace(one, numbers=tuple(replace(item, source="mediapipe video") for item in one.numbers))
        for one in (past(0), past(1, pip_deg=50.0))
    ]
    assert change(seen[0], seen[1], *ROM, nothing_known).verdict == "below MDC"


@given(st.floats(5.0, 120.0), st.floats(5.0, 120.0))
def test_a_change_back_is_the_same_change_turned_round(before: float, after: float) -> None:
    there = change(past(0, pip_deg=before), past(1, pip_deg=after), *ROM, nothing_known)
    back = change(past(1, pip_deg=after), past(2, pip_deg=before), *ROM, nothing_known)
    assert there.difference == pytest.approx(-back.difference)
    assert there.verdict == back.verdict


@pytest.mark.parametrize(
    ("changes", "name", "reason"),
    [
        ({"side": "left"}, "range_of_motion", "another hand"),
        ({"modes": ("transparent",)}, "range_of_motion", "mode, then"),
        ({"exercise": "pinch"}, "range_of_motion", "another exercise"),
        ({"stiffness": 1.2}, "fingertip_rmse", "another stiffness"),
        ({"stiffness": math.nan}, "fingertip_rmse", "another stiffness"),
        ({"pip_deg": None}, "range_of_motion", "not measured in both"),
    ],
)
def test_unlike_sessions_are_not_compared(changes: dict[str, Any], name: str, reason: str) -> None:
    subject = "index_pip" if name == "range_of_motion" else "index"
    one, other = past(0, **changes), past(1)
    assert reason in comparable(one, other, name, subject)
    judged = change(one, other, name, subject, nothing_known)
    assert judged.verdict == "not measurable"
    assert math.isnan(judged.difference)


def test_another_source_or_method_is_not_compared() -> None:
    for field, value in (("source", "camera"), ("version", "2")):
        other = past(1)
        other = replace(other, numbers=tuple(replace(item, **{field: value}) for item in other.numbers))
        assert comparable(past(0), other, *ROM)


def test_baseline_last_and_now_are_of_comparable_sessions_only() -> None:
    found = progress(
        past(0, pip_deg=90.0, modes=("passive",)),
        past(1, pip_deg=40.0),
        past(2, pip_deg=45.0),
        past(3, pip_deg=50.0),
    )
    shown = line(found, *ROM)
    assert shown is not None
    assert shown.baseline is not None
    assert shown.last is not None
    values = [math.degrees(item.value or 0.0) for item in (shown.baseline, shown.last, shown.now)]
    assert values == pytest.approx([40.0, 45.0, 50.0])
    assert shown.others[0] == 1


def test_what_a_camera_can_tell_is_no_bound_for_an_encoder() -> None:
    bounds = (("range_of_motion", "", "camera", math.radians(30.0)),)
    by_camera = line(progress(past(0), past(1, pip_deg=60.0), bounds=bounds), *ROM)
    without = line(progress(past(0), past(1, pip_deg=60.0)), *ROM)
    assert by_camera is not None
    assert without is not None
    assert by_camera.change == without.change


def test_the_sentences_credit_nobody_and_call_nothing_real_that_may_be_nothing() -> None:
    for gain in (0.0, 1.9, 4.0, 12.0):
        words = told(progress(past(0), past(1, pip_deg=40.0 + gain)))
        assert ("a real gain of 12°" in words) == (gain == 12.0)
        for credit in ("thanks", "because", "improved", "helped you", "the robot gained"):
            assert credit not in words


def test_a_gain_that_stretching_alone_makes_is_called_that() -> None:
    bounds = (("range_of_motion", "", "encoder", math.radians(1.0)),)
    numbers = (kept("range_of_motion", "index_pip", math.radians(41.8), 0.001),)
    first = replace(past(0), numbers=(kept("range_of_motion", "index_pip", math.radians(40.0), 0.001),))
    found = progress(first, replace(past(1), numbers=numbers), bounds=bounds)
    assert "as small as stretching alone makes" in told(found)
    assert "no more than stretching alone gains" in render_progress(found, "html").decode().lower()


def test_missing_is_shown_as_missing() -> None:
    empty = progress(left_out=(LeftOut("s9", past(9).utc_start_ns, "its file is gone"),))
    page = render_progress(empty, "html").decode()
    assert "nothing can be said of progress" in page
    assert "its file is gone" in page
    assert ">nan<" not in page.lower()
    gap = render_progress(progress(past(0), past(1, pip_deg=None)), "html").decode()
    assert "—" in gap


def test_every_format_says_the_same_and_names_its_source() -> None:
    score = Score("Box and Block, right", "12", "—", "19", "+7", "better, matters (published: 6)")
    found = progress(*(past(day, pip_deg=40.0 + 3 * day) for day in range(4)), scores=(score,), ordered=8)
    made = {name: render_progress(found, name) for name in PROGRESS_FORMATS}
    page = made["html"].decode()
    assert "by encoder" in page
    assert "matters (published: 6)" in page
    assert "stiffness 0.90 Nm/rad" in page
    content = json.loads(made["json"])
    rom = next(item for item in content["changes"] if (item["name"], item["subject"]) == ROM)
    assert rom["verdict"] == "real"
    assert math.degrees(rom["difference"]) == pytest.approx(9.0)
    assert made["pdf"].startswith(b"%PDF")
    assert "Index PIP +9°" in made["note"].decode()
    assert made["csv"].decode().count("\r\n") == 1 + sum(len(one.numbers) for one in found.pasts)
    assert made == {name: render_progress(found, name) for name in PROGRESS_FORMATS}


def test_a_past_survives_being_kept_and_knows_what_went_against_a_repetition(make_session: Any) -> None:
    summary = measure(make_session())
    found = past_of(summary, [(4.0, "pain"), (4.2, "reversal"), (4.3, "note"), (99.0, "load")])
    assert past_from_json(past_to_json(found)) == found
    assert [one.troubles for one in found.trials] == [(), ("pain", "reversed"), ()]
    assert found.trials[0] == Trial(0, True, "robot", ())
    assert found.value("joint_rmse") > 0.0
