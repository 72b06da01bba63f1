"""Opening, closing, norms, grades, lag and rhythm: laws and oracles."""

from __future__ import annotations

import math

import numpy as np
import pytest

from rehab_app.hand.subject import geometry_to_json
from robot_iface.kinematics import average_hand, forward
from sessions.metrics.dose import adherence
from sessions.metrics.finger_bones import bones_of, finger_points_m
from sessions.metrics.hand_opening import held_distance, kapandji, palm_distance_m, tip_distance
from sessions.metrics.metric import Estimate
from sessions.metrics.motion_range import total_active_motion
from sessions.metrics.norms import ASSH, active_motion_share, grade, lag, norm_of, share_of
from sessions.metrics.rhythm import decrement, pauses
from sessions.records import DIGITS, FINGERS, JOINTS, LANDMARKS, Side

TIPS = [LANDMARKS.index(f"{digit}_tip") for digit in DIGITS]


def rad(*degrees: float) -> np.ndarray:
    return np.deg2rad(np.array(degrees))


def test_total_active_motion_share_and_grade() -> None:
    share, words = active_motion_share(total_active_motion(rad(85, 110, 65), rad(0, 0, -5)))
    assert share.value == pytest.approx(1.0)
    assert words == f"excellent ({ASSH})"
    share, words = active_motion_share(total_active_motion(rad(60, 70, 30), rad(5, 10, 5)))
    assert round(100 * share.value, 1) == 53.8
    assert words.startswith("fair")
    assert [grade(value) for value in (1.0, 0.999, 0.751, 0.75, 0.501, 0.5, 0.0)] == [
        "excellent", "good", "good", "fair", "fair", "poor", "poor",
    ]  # fmt: skip
    assert active_motion_share(Estimate.missing("no fist"))[1] == ""


def test_error_of_total_active_motion_adds_in_squares_and_hyperextension_adds_none() -> None:
    std = np.full(3, 0.01)
    interval = total_active_motion(rad(60, 70, 30), rad(5, 10, -5), std, std).interval
    assert interval is not None
    assert interval[1] - interval[0] == pytest.approx(2 * 1.959964 * 0.01 * math.sqrt(5))


def test_norms_and_the_other_side() -> None:
    assert [norm_of(joint) for joint in ("index_mcp_flexion", "little_pip", "ring_dip", "thumb_ip")] == (
        pytest.approx(np.deg2rad([90, 100, 80, 80]))
    )
    assert norm_of("index_mcp_abduction") is None
    share = share_of(Estimate(0.8, (0.7, 0.9)), Estimate(1.0, (0.9, 1.1)))
    assert share.value == pytest.approx(0.8)
    assert share.interval == pytest.approx((0.8 - math.hypot(0.1, 0.08), 0.8 + math.hypot(0.1, 0.08)))
    assert math.isnan(share_of(Estimate(1.0), Estimate(0.0)).value)
    assert share_of(Estimate.missing("lost"), Estimate(1.0)).reason == "lost"


def test_lag_is_what_the_joint_itself_does_not_lack() -> None:
    found = lag(Estimate(rad(30)[0], (0.5, 0.55)), Estimate(rad(10)[0], (0.15, 0.2)))
    assert math.degrees(found.extension_lag.value) == pytest.approx(20.0)
    assert math.degrees(found.contracture.value) == pytest.approx(10.0)
    assert lag(Estimate(0.1), Estimate(-0.3)).extension_lag.value == pytest.approx(0.1)
    assert lag(Estimate(0.1), Estimate(0.3)).extension_lag.value == 0.0
    assert math.isnan(lag(Estimate.missing("none"), Estimate(0.3)).extension_lag.value)


@pytest.mark.parametrize("side", ["right", "left"])
def test_finger_joints_are_those_of_the_hand_model(side: Side) -> None:
    hand = average_hand(0.189, side)
    bones = bones_of(geometry_to_json(hand))
    assert bones is not None
    rng = np.random.default_rng(1)
    joints = rng.uniform(0.0, 1.5, (100, len(JOINTS)))
    joints[:, [column for column, name in enumerate(JOINTS) if "abduction" in name]] *= 0.15
    landmarks = forward(hand, joints).landmarks_m
    for finger in FINGERS:
        rows = [LANDMARKS.index(f"{finger}_{part}") for part in ("mcp", "pip", "dip", "tip")]
        found = finger_points_m(bones, finger, landmarks[:, rows[3]], joints)
        np.testing.assert_allclose(found, landmarks[:, rows], atol=1e-12)


@pytest.mark.parametrize(
    "text", ["", "{", "[]", '{"side": "right"}', '{"bases_m": 1, "bones_m": 2, "side": ""}']
)
def test_a_header_without_a_hand_has_no_bones(text: str) -> None:
    assert bones_of(text) is None


def test_kapandji_counts_the_farthest_place_that_the_thumb_reached() -> None:
    bones = bones_of(geometry_to_json(average_hand()))
    assert bones is not None
    joints = np.zeros((6, len(JOINTS)))
    tips = forward(average_hand(), joints).landmarks_m[:, TIPS]
    assert kapandji(bones, tips, joints).value == 0
    places = forward(average_hand(), joints).landmarks_m[0]
    for place, name in ((3, "index_tip"), (6, "little_tip"), (7, "little_dip"), (8, "little_pip")):
        moved = tips.copy()
        moved[0, 0] = places[LANDMARKS.index(name)]
        found = kapandji(bones, moved, joints)
        assert found.value == place
        assert "not from touch" in found.reason
    lost = np.full_like(tips, math.nan)
    assert kapandji(bones, lost, joints).reason.startswith("thumb and fingers were never")


def test_distances_are_held_and_carry_both_errors() -> None:
    t = np.arange(300) / 60
    tips = np.zeros((300, 5, 3))
    tips[:, 0, 0] = 0.05 + 0.03 * np.sin(2 * np.pi * 0.5 * t)
    distance, std = tip_distance(tips, np.full((300, 5), 0.001), "thumb", "index")
    found = held_distance(t, distance, std, largest=True)
    assert found.value == pytest.approx(0.08, abs=5e-4)
    assert found.interval is not None
    assert found.interval[1] - found.value == pytest.approx(1.959964 * 0.001 * math.sqrt(2))
    assert held_distance(t, distance, std, largest=False).value == pytest.approx(0.02, abs=5e-4)
    assert math.isnan(held_distance(t[:5], distance[:5], std[:5], largest=True).value)


def test_a_fist_is_nearer_to_the_palm_than_an_open_hand() -> None:
    hand = average_hand()
    bones = bones_of(geometry_to_json(hand))
    assert bones is not None
    fist = np.zeros((2, len(JOINTS)))
    for column, joint in enumerate(JOINTS):
        fist[1, column] = 0.0 if "abduction" in joint or "thumb" in joint else math.radians(90)
    tips = forward(hand, fist).landmarks_m[:, TIPS]
    for row, finger in enumerate(FINGERS, start=1):
        open_m, closed_m = palm_distance_m(bones, finger, tips[:, row])
        assert closed_m < 0.035 < 0.07 < open_m


def test_decrement_of_a_straight_line_and_pauses_between() -> None:
    found = decrement(np.linspace(1.0, 0.7, 10))
    assert found.value == pytest.approx(0.3)
    assert found.interval == pytest.approx((0.3, 0.3), abs=1e-9)
    assert decrement(np.ones(5)).reason == "fewer than three repetitions"
    t = np.arange(0.0, 6.0, 1 / 60)
    moving = np.interp(t, [0, 1, 3, 4, 6], [0, 1, 1, 0, 0])
    rest = pauses(t, moving, np.array([[0.0, 1.0], [3.0, 4.0]]))
    assert rest.count.value == 1
    assert rest.longest.value == pytest.approx(2.0, abs=0.2)
    assert pauses(t, moving, np.empty((0, 2))).count.reason == "fewer than two strokes"


def test_adherence_is_sessions_held_over_sessions_ordered() -> None:
    assert adherence(6, 28.0, 3).value == pytest.approx(0.5)
    assert math.isnan(adherence(1, 0.0, 3).value)
    assert math.isnan(adherence(1, 7.0, 0).value)
