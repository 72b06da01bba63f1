from __future__ import annotations

import numpy as np
import pytest

from rehab_app.geometry.detections import Detections, joined, lifted
from rehab_app.geometry.pinhole import KINECT
from rehab_app.hand.marker_model import MarkerModel
from rehab_app.hand.subject import average_subject
from rehab_app.tracking.bare_hand import BareHandTracker, bare_hand_protocol, learn_bare_hand
from rehab_app.tracking.bare_hand_points import points_of
from robot_iface.kinematics import couple_dip
from sessions.errors import Refused
from sessions.records import JOINTS, Status
from sessions.records.fields import Float64

PERIOD_NS = 33_333_333
FACING = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, -1.0], [-1.0, 0.0, 0.0]])  # palm towards the camera


def joints_at(index: int) -> Float64:
    """Closing and opening in three seconds."""
    share = 0.5 - 0.5 * np.cos(2 * np.pi * index / 90)
    joints = np.array([0.9 * share * name.endswith(("mcp_flexion", "pip", "_ip")) for name in JOINTS])
    joints[:5] *= 0.4
    return couple_dip(joints)


def sighting(index: int, rng: np.random.Generator, scale: float = 1.0, std_m: float = 0.001) -> Detections:
    protocol = bare_hand_protocol(metric=True)
    model = MarkerModel(average_subject(protocol, "right", 0.175), protocol)
    p_m = model.positions(joints_at(index)) @ FACING.T + [0.02, 0.08, 0.6]
    p_m = scale * (p_m + std_m * rng.standard_normal(p_m.shape))
    std = np.full(21, 0.003)
    return lifted(
        PERIOD_NS * index,
        KINECT.project(p_m),
        p_m[:, 2],
        KINECT,
        pixel_std_px=std * 525.0 / p_m[:, 2],
        depth_std_m=std,
        similarity=np.full(21, 0.95),
    )


def nothing(index: int) -> Detections:
    return sighting(index, np.random.default_rng(0)).rows(np.empty(0, dtype=np.int64))


def run(count: int, metric: bool = True, scale: float = 1.0) -> tuple[BareHandTracker, Float64]:
    rng = np.random.default_rng(2)
    tracker = BareHandTracker("right", metric=metric)
    joints: list[Float64] = []
    for index in range(count):
        joints += [one.pose.joints_rad for one in tracker.observe(sighting(index, rng, scale))]
    return tracker, np.array(joints)


def test_the_hand_is_learnt_then_all_that_was_held_back_is_told() -> None:
    tracker = BareHandTracker("right", metric=True)
    rng = np.random.default_rng(2)
    assert (tracker.state, tracker.subject, tracker.observe(nothing(0))) == ("searching", None, ())
    told = [tracker.observe(sighting(index, rng)) for index in range(1, 62)]
    assert [len(part) for part in told] == [0] * 59 + [61, 1]
    assert tracker.state == "tracking"
    first, second = told[59][:2]
    assert (first.markers.status == Status.LOST).all()
    assert (second.markers.status == Status.MEASURED).all()
    np.testing.assert_array_equal(second.detection, np.arange(21))
    times = [one.pose.t_ns for part in told for one in part]
    assert times == [PERIOD_NS * index for index in range(62)]


def test_joints_and_length_are_those_of_the_hand() -> None:
    tracker, joints = run(90)
    truth = np.array([joints_at(index) for index in range(90)])
    assert np.rad2deg(np.sqrt(((joints - truth) ** 2).mean())) < 4.0
    assert tracker.subject is not None
    assert tracker.subject.geometry.length_m == pytest.approx(0.175, rel=0.02)


def test_without_depth_the_scale_does_not_change_the_joints() -> None:
    _, joints = run(70, metric=False)
    _, larger = run(70, metric=False, scale=1.15)
    assert np.rad2deg(np.abs(joints - larger).max(axis=1)).mean() < 6.0


def test_the_same_landmarks_give_the_same_hand() -> None:
    np.testing.assert_array_equal(run(65)[1], run(65)[1])


def test_a_gap_is_a_gap_and_the_hand_comes_back() -> None:
    rng = np.random.default_rng(2)
    subject = learn_bare_hand([sighting(index, rng) for index in range(0, 90, 3)], "right", metric=True)
    tracker = BareHandTracker("right", metric=True, subject=subject)
    tracker.observe(sighting(0, rng))
    states = []
    for index in range(1, 21):
        (one,) = tracker.observe(nothing(index))
        states.append(one.state)
        assert np.isnan(one.pose.joints_rad).all()
        assert (one.pose.joint_status == Status.LOST).all()
    assert (states[0], states[-1], tracker.state) == ("tracking", "lost", "lost")
    (back,) = tracker.observe(sighting(45, rng))  # a fist, after an open hand
    assert tracker.state == "tracking"
    assert np.rad2deg(np.abs(back.pose.joints_rad - joints_at(45))[JOINTS.index("middle_pip")]) < 10.0


def test_a_guessed_landmark_is_estimated_and_counts_for_less() -> None:
    rng = np.random.default_rng(2)
    subject = learn_bare_hand([sighting(index, rng) for index in range(0, 90, 3)], "right", metric=True)
    tracker = BareHandTracker("right", metric=True, subject=subject)
    seen = sighting(10, rng)
    seen.similarity[12] = 0.3
    (one,) = tracker.observe(seen)
    expected = np.full(21, Status.MEASURED)
    expected[12] = Status.ESTIMATED
    np.testing.assert_array_equal(one.markers.status, expected)


def test_two_cameras_are_surer_than_one() -> None:
    rng = np.random.default_rng(2)
    here, there = sighting(10, rng), sighting(10, rng)
    both = points_of(joined([here, there]), metric=True)
    mean = 0.5 * (here.p_camera_m + there.p_camera_m)
    assert np.abs(both.p_camera_m - mean).max() < 1e-3
    assert (both.std_m < 0.75 * points_of(here, metric=True).std_m).all()


def test_what_cannot_be_a_hand_is_complained_of() -> None:
    rng = np.random.default_rng(2)
    tracker = BareHandTracker("right", metric=True, doubt=lambda: "odd")
    assert tracker.complaint == "odd"
    for index in range(60):
        assert tracker.observe(sighting(index, rng, scale=3.0)) == ()
    assert "hand in the recording" in (tracker.complaint or "")
    assert tracker.state == "searching"
    with pytest.raises(Refused):
        learn_bare_hand([], "right", metric=True)
