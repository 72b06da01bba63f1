from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from sessions.errors import Refused
from sessions.metrics import DEFINITIONS, Summary, measure
from sessions.records import DIGITS, JOINTS
from sessions.records.topics import HAND_POSE, PATIENT_POSE, PHASE, REFERENCE, ROBOT_COMMAND, ROBOT_STATE

Make = Callable[..., Any]
PIP = JOINTS.index("index_pip")


def value(summary: Summary, name: str, subject: str = "whole") -> float:
    found = summary.metric(name, subject)
    assert found is not None, f"{name} of {subject}"
    return found.value


def status(summary: Summary, name: str, subject: str = "whole") -> str:
    found = summary.metric(name, subject)
    assert found is not None, f"{name} of {subject}"
    return found.status


@pytest.mark.parametrize("noise_deg", [0.0, 0.7])
def test_forty_degrees_of_index_pip_come_out_of_a_take(make_take: Make, noise_deg: float) -> None:
    summary = measure(make_take(noise_rad=np.deg2rad(noise_deg)))
    assert np.rad2deg(value(summary, "range_of_motion", "index_pip")) == pytest.approx(40.0, abs=2.0)
    found = summary.metric("range_of_motion", "index_pip")
    assert found is not None
    assert found.lineage.topics == (HAND_POSE.name,)
    assert found.lineage.file_sha256 == summary.sha256
    assert found.lineage.source == "virtual-camera"
    assert value(summary, "repetitions") == 3


def test_smoothness_of_minimum_jerk_strokes_is_near_its_oracle_and_its_floor(make_take: Make) -> None:
    summary = measure(make_take())
    assert value(summary, "sparc", "index") == pytest.approx(-1.43, abs=0.05)
    noisy = make_take()
    tips = noisy.topics[HAND_POSE.name]["fingertips_palm_m"]
    tips += np.random.default_rng(3).normal(0.0, 0.0005, tips.shape)
    assert value(measure(noisy), "sparc_floor", "index") < value(summary, "sparc_floor", "index")
    assert value(summary, "ldlj", "index") > -7.0
    assert status(summary, "sparc", "little").startswith("not measurable")
    assert "arms" in status(summary, "sparc", "index")
    quiet = make_take()
    quiet.topics[HAND_POSE.name]["fingertip_covariance_m2"][:] = 0.0
    floor = value(measure(quiet), "sparc_floor", "index")
    assert floor == pytest.approx(value(summary, "sparc", "index"), abs=0.06)
    conditions = summary.named("sparc")[DIGITS.index("index")].lineage.conditions
    assert "Butterworth" in conditions
    assert "60 samples/s" in conditions


def test_markers_that_were_lost_show(make_take: Make) -> None:
    summary = measure(make_take())
    assert value(summary, "valid_share", "thumb_cmc") == pytest.approx(1 - 30 / 600)
    assert value(summary, "longest_gap", "thumb_cmc") == pytest.approx(0.5, abs=1e-6)
    assert value(summary, "fit_residual") == pytest.approx(0.0012)


def test_estimated_angles_are_flagged_and_lost_ones_are_not_measurable(make_take: Make) -> None:
    take = make_take()
    joint_status = take.topics[HAND_POSE.name]["joint_status"]
    joint_status[:, PIP] = 1
    joint_status[:, PIP + 1] = 0
    summary = measure(take)
    assert status(summary, "range_of_motion", "index_pip").startswith("flagged: estimated")
    assert status(summary, "range_of_motion", "index_dip").startswith("not measurable")
    assert status(summary, "sparc", "index").startswith("not measurable")
    assert status(summary, "total_active_motion", "index").startswith("not measurable")


def test_a_constant_lag_is_the_error_of_its_joint(make_session: Make) -> None:
    summary = measure(make_session(offset_rad=np.deg2rad(3.0)))
    assert math.degrees(value(summary, "joint_rmse", "index_pip")) == pytest.approx(3.0)
    assert value(summary, "joint_rmse", "middle_pip") == pytest.approx(0.0, abs=1e-12)
    assert math.degrees(value(summary, "joint_rmse")) == pytest.approx(3.0 / 2)  # four measured joints
    assert status(summary, "joint_rmse", "index_dip").startswith("flagged: estimated")
    assert value(summary, "fingertip_rmse", "index") > 1e-3
    assert value(summary, "fingertip_rmse", "little") == pytest.approx(0.0, abs=1e-12)
    for repetition in summary.repetitions:
        assert math.degrees(repetition.rmse_rad) == pytest.approx(1.5)
        assert repetition.completed
        assert math.isnan(repetition.robot_share)
    assert "in passive mode" in status(summary, "robot_share")


def test_only_moving_and_holding_count(make_session: Make) -> None:
    session = make_session()
    rows = session.topics[PATIENT_POSE.name]
    rows["joints_rad"][:50, PIP] += 1.0  # during the ramp
    assert math.degrees(value(measure(session), "joint_rmse", "index_pip")) == pytest.approx(3.0)


def test_error_stands_beside_the_stiffness_or_not_at_all(make_session: Make) -> None:
    summary = measure(make_session())
    assert summary.conditions == "stiffness 0.90 Nm/rad (3.0 times the thesis gains), passive mode"
    assert value(summary, "stiffness", "index_pip") == pytest.approx(0.9)
    assert value(summary, "assistance", "index") == pytest.approx(3.0)
    assert status(summary, "assistance", "thumb").startswith("not measurable")
    found = summary.metric("joint_rmse", "index_pip")
    assert found is not None
    assert "0.90 Nm/rad" in found.lineage.conditions
    unknown = make_session().without(ROBOT_COMMAND)
    unknown.topics[PHASE.name]["assistance"][:] = np.nan
    hidden = measure(unknown)
    assert hidden.conditions == ""
    for item in (*hidden.named("joint_rmse"), *hidden.named("fingertip_rmse")):
        assert item.status.startswith("not measurable: the stiffness")
    assert all(math.isnan(item.rmse_rad) for item in hidden.repetitions)


def test_dose_and_stops(make_session: Make) -> None:
    summary = measure(make_session())
    assert value(summary, "repetitions") == 3
    assert value(summary, "repetitions_by_patient") == 0
    assert value(summary, "dose_completed") == pytest.approx(1.0)
    assert value(summary, "dose_time") == pytest.approx(3 * 2.6, abs=0.01)
    assert value(summary, "stops") == 0
    stopped = measure(make_session(stopped=True))
    assert [stop.cause for stop in stopped.stops] == ["e-stop"]
    assert [item.completed for item in stopped.repetitions] == [True, True, False]
    assert value(stopped, "dose_completed") == pytest.approx(2 / 3)


def test_a_session_without_robot_state_still_reports_the_rest(make_session: Make) -> None:
    summary = measure(make_session().without(ROBOT_STATE))
    assert status(summary, "robot_share").startswith("not measurable")
    assert value(summary, "joint_rmse", "index_pip") > 0


def test_motion_by_the_robot_is_not_called_active(make_session: Make) -> None:
    assert "the robot moved the hand" in status(measure(make_session()), "total_active_motion", "index")


@pytest.mark.parametrize("topic", [PATIENT_POSE, REFERENCE, PHASE])
def test_a_session_without_what_it_needs_is_refused(make_session: Make, topic: Any) -> None:
    with pytest.raises(Refused, match=topic.name):
        measure(make_session().without(topic))


def test_a_take_without_poses_is_refused(make_take: Make) -> None:
    with pytest.raises(Refused, match="hand poses"):
        measure(make_take().without(HAND_POSE))


def test_every_number_is_in_the_registry_and_finite_or_explained(make_take: Make, make_session: Make) -> None:
    for summary in (measure(make_take()), measure(make_session())):
        for item in summary.metrics:
            known = DEFINITIONS[item.name]
            assert (item.unit, item.version) == (known.unit, known.version)
            assert math.isfinite(item.value) != item.status.startswith("not measurable")
            if item.interval is not None:
                assert item.interval[0] <= item.value <= item.interval[1]
        subjects = [(item.name, item.subject) for item in summary.metrics]
        assert len(subjects) == len(set(subjects))


def test_the_same_file_gives_the_same_summary(make_take: Make) -> None:
    first, second = measure(make_take(noise_rad=0.01)), measure(make_take(noise_rad=0.01))
    for one, other in zip(first.metrics, second.metrics, strict=True):
        assert repr(dataclasses.astuple(one)) == repr(dataclasses.astuple(other))


def test_the_overlay_is_the_last_completed_repetition(make_session: Make) -> None:
    overlay = measure(make_session(stopped=True)).overlay
    assert overlay.shown == "repetition 2 of 3"
    assert overlay.reference is not None
    assert overlay.hand.joints_rad.shape == overlay.reference.joints_rad.shape
    assert overlay.hand.fingertips_palm_m.shape[1:] == (len(DIGITS), 3)
    assert len(overlay.hand.t_s) <= 600


def test_a_repetition_with_two_stretches_is_one_account(make_session: Make) -> None:
    session = make_session()
    names = session.topics[PHASE.name]["phase"]
    moving = np.flatnonzero((session.topics[PHASE.name]["repetition"] == 1) & (names == "move"))
    names[moving[8:10]] = "rest"  # a pause within the movement
    summary = measure(session)
    assert [item.index for item in summary.repetitions] == [0, 1, 2]
    assert value(summary, "dose_time") == pytest.approx(3 * 2.6 - 0.2, abs=0.01)
