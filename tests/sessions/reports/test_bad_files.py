"""Files that are not as they should be: a report that says so, or a refusal with the reason."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from sessions.errors import Refused
from sessions.metrics import measure
from sessions.records import JOINTS
from sessions.records.topics import HAND_POSE, PATIENT_POSE, PHASE, REFERENCE
from sessions.reports import Report, render_html, render_json

Make = Callable[..., Any]
LITTLE = [column for column, joint in enumerate(JOINTS) if joint.startswith("little")]


def statuses(recording: Any, *names: str) -> list[str]:
    return [item.status for item in measure(recording).metrics if item.name in names]


def renders(recording: Any) -> str:
    report = Report((measure(recording),), "0")
    assert b"NaN" not in render_json(report)
    return render_html(report)


def test_a_session_without_repetitions_is_refused(make_session: Make) -> None:
    session = make_session()
    session.topics[PHASE.name]["phase"][:] = "rest"
    with pytest.raises(Refused, match="without a repetition"):
        measure(session)
    lost = make_session()
    lost.topics[PHASE.name]["repetition"][:] = -1  # phases that belong to no repetition
    summary = measure(lost)
    assert summary.repetitions == ()
    for item in summary.named("joint_rmse"):
        assert not item.measurable, item


def test_a_missing_finger_is_missing_and_the_others_stay(make_take: Make, make_session: Make) -> None:
    take = make_take()
    take.topics[HAND_POSE.name]["joint_status"][:, LITTLE] = 0
    summary = measure(take)
    for item in summary.metrics:
        seen = item.name in ("valid_share", "longest_gap")
        if not seen and (item.subject == "little" or item.subject.startswith("little_")):
            assert not item.measurable, item
    span = summary.metric("span")
    assert span is not None
    assert not span.measurable
    index = summary.metric("range_of_motion", "index_pip")
    assert index is not None
    assert index.status == "ok"
    assert "not measurable" not in index.status
    renders(take)
    session = make_session()
    session.topics[PATIENT_POSE.name]["joint_status"][:, LITTLE] = 0
    assert all(
        not item.measurable for item in measure(session).named("fingertip_rmse") if item.subject == "little"
    )


def test_estimated_frames_have_no_unflagged_angle_and_no_total(make_take: Make, make_session: Make) -> None:
    take, session = make_take(), make_session()
    take.topics[HAND_POSE.name]["joint_status"][:] = 1
    session.topics[PATIENT_POSE.name]["joint_status"][:] = 1
    for recording in (take, session):
        words = statuses(recording, "range_of_motion", "angle_min", "angle_max")
        assert all("estimated" in status or status.startswith("not measurable") for status in words)
        assert "ok" not in statuses(recording, "total_active_motion", "joint_rmse")
        renders(recording)


def test_a_reference_at_other_times_compares_nothing(make_session: Make) -> None:
    session = make_session()
    session.topics[REFERENCE.name]["t_ns"] = session.topics[REFERENCE.name]["t_ns"] + 1
    summary = measure(session)
    for name in ("joint_rmse", "fingertip_rmse", "timing_delay", "shape_error"):
        assert not any(item.measurable for item in summary.named(name))
    renders(session)


@pytest.mark.parametrize("jump_s", [-3600.0, 3600.0])
def test_a_clock_that_jumps_changes_no_angle(make_session: Make, jump_s: float) -> None:
    session, straight = make_session(), measure(make_session())
    for rows in session.topics.values():
        if len(rows["t_ns"]):
            late = rows["t_ns"] >= straight.named("range_of_motion")[0].lineage.t_end_ns - 3 * 10**9
            rows["t_ns"] = rows["t_ns"] + np.where(late, round(jump_s * 1e9), 0)
    summary = measure(session)
    for one, other in zip(summary.named("range_of_motion"), straight.named("range_of_motion"), strict=True):
        if one.measurable and other.measurable:
            assert one.value <= other.value + 1e-2
    torque = [item for item in summary.metrics if item.name == "robot_work" and item.measurable]
    before = straight.metric("robot_work")
    assert before is not None
    assert all(item.value <= 1.05 * before.value for item in torque)


def test_two_patients_in_one_report_stay_apart(make_session: Make) -> None:
    one, other = make_session(), make_session()
    other.header = replace(other.header, subject_id="P-0002")
    other.sha256 = "c3" * 32
    page = render_html(Report((measure(one), measure(other)), "0"))
    assert "P-0001" in page
    assert "P-0002" in page
