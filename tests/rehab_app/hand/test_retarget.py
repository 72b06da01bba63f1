from __future__ import annotations

import numpy as np
import pytest

from rehab_app.hand.retarget import ROBOT_JOINTS, retarget, whole_robot_hand
from robot_iface.build import capabilities
from robot_iface.kinematics import HandGeometry, average_hand, couple_dip, forward
from robot_iface.kinematics.dlr_hit import FINGER_MAX_RAD, FINGER_MIN_RAD, LINKS_M, finger_points
from sessions.records import DIGITS, FINGERS, JOINTS
from sessions.records.fields import Float64

LOW, HIGH = np.tile(FINGER_MIN_RAD, 5), np.tile(FINGER_MAX_RAD, 5)
HAND = average_hand()


def like_the_robot() -> HandGeometry:
    """A person whose every digit has the robot's proportions."""
    bones = np.tile(np.array(LINKS_M), (5, 1))
    return HandGeometry("right", HAND.bases_m, HAND.base_rotation, bones, HAND.palm_m)


def closings(count: int = 60) -> Float64:
    """From open to a fist, shape (count, 21)."""
    joints = np.zeros((count, 21))
    share = np.linspace(0.05, 1.0, count)
    for finger in FINGERS:
        column = JOINTS.index(f"{finger}_mcp_flexion")
        joints[:, column], joints[:, column + 2] = np.deg2rad(70) * share, np.deg2rad(85) * share
    joints[:, JOINTS.index("thumb_mcp_flexion")] = np.deg2rad(40) * share
    joints[:, JOINTS.index("thumb_ip")] = np.deg2rad(50) * share
    return couple_dip(joints)


def test_the_joints_are_those_of_the_device() -> None:
    device = capabilities("dlr-hit-ii")
    assert device.joint_names == ROBOT_JOINTS
    np.testing.assert_allclose(device.q_min_rad, LOW)
    np.testing.assert_allclose(device.q_max_rad, HIGH)


def test_a_hand_of_the_robots_proportions_keeps_its_angles() -> None:
    rng = np.random.default_rng(1)
    robot = np.tile(np.deg2rad([0.0, 40.0, 40.0]), (200, 5))
    robot += rng.uniform(-1.0, 1.0, robot.shape) * np.tile(np.deg2rad([9.0, 33.0, 33.0]), 5)
    found = retarget(like_the_robot(), whole_robot_hand(robot), LOW, HIGH)
    fingers = slice(3, None)
    np.testing.assert_allclose(found.joints_rad[:, fingers], robot[:, fingers], atol=np.deg2rad(0.05))
    assert found.residual_m[:, 1:].max() < 1e-4


def test_the_residual_is_the_distance_of_the_like_places() -> None:
    """Oracle: both chains by their own forward kinematics, each seen from its base over its length."""
    joints = closings()
    found = retarget(HAND, joints, LOW, HIGH)
    marks = forward(HAND, joints).landmarks_m
    for number, finger in enumerate(FINGERS, start=1):
        apart = marks[:, 4 * number + 3] - HAND.bases_m[number]  # palmar, radial, distal
        human = np.stack([apart[:, 2], apart[:, 1], -apart[:, 0]], axis=1) / HAND.bones_m[number].sum()
        robot = finger_points(found.joints_rad[:, 3 * number : 3 * number + 3])[:, 3] / sum(LINKS_M)
        expected = sum(LINKS_M) * np.linalg.norm(human - robot, axis=1)
        np.testing.assert_allclose(found.residual_m[:, number], expected, atol=1e-9, err_msg=finger)


def test_a_fist_is_shown_within_a_centimetre_inside_the_ranges_and_smoothly() -> None:
    joints = closings(200)
    found = retarget(HAND, joints, LOW, HIGH)
    assert (found.joints_rad > LOW).all()
    assert (found.joints_rad < HIGH).all()
    assert found.residual_m[:, 1:].max() < 0.010
    steps = np.diff(found.joints_rad, axis=0)
    assert np.abs(np.diff(steps, axis=0)).max() < 0.15 * np.abs(steps).max()


def test_it_is_the_best_posture_not_just_a_good_one() -> None:
    """No nearby angles of MCP and PIP bring tip and pointing nearer."""
    joints = closings(5)[2:3]
    found = retarget(HAND, joints, LOW, HIGH).joints_rad[0, 3:6]
    flexions = joints[0, [5, 7, 8]]
    human = HAND.bones_m[1] / HAND.bones_m[1].sum()
    turned = np.cumsum(flexions)
    place = np.array([human @ np.cos(turned), human @ np.sin(turned)])

    def cost(mcp: float, pip: float) -> float:
        angles = mcp + pip * np.arange(3)
        parts = np.array(LINKS_M) / sum(LINKS_M)
        tip = np.array([parts @ np.cos(angles), parts @ np.sin(angles)])
        return float(((tip - place) ** 2).sum() + (0.15 * (turned[2] - angles[2])) ** 2)

    best = cost(found[1], found[2])
    for step in np.deg2rad([[0.5, 0], [-0.5, 0], [0, 0.5], [0, -0.5], [0.5, -0.5], [-0.5, 0.5]]):
        assert cost(found[1] + step[0], found[2] + step[1]) > best


def test_what_the_robot_cannot_make_is_asked_for_but_not_made() -> None:
    joints = np.zeros((1, 21))
    joints[0, JOINTS.index("index_mcp_abduction")] = np.deg2rad(20)
    joints[0, JOINTS.index("middle_mcp_flexion")] = np.deg2rad(95)
    found = retarget(HAND, joints, LOW, HIGH)
    asked = dict(zip(ROBOT_JOINTS, np.rad2deg(found.asked_rad[0]), strict=True))
    made = dict(zip(ROBOT_JOINTS, np.rad2deg(found.joints_rad[0]), strict=True))
    assert asked["index_mcp_abduction"] == pytest.approx(20.0)
    assert made["index_mcp_abduction"] == pytest.approx(15.0, abs=0.6)
    assert asked["middle_mcp_flexion"] == pytest.approx(95.0, abs=0.5)
    assert made["middle_mcp_flexion"] == pytest.approx(80.0, abs=0.6)
    assert found.residual_m[0, DIGITS.index("middle")] > 0.02


def test_a_left_hand_is_shown_as_its_mirror_image() -> None:
    joints = closings(10)
    joints[:, JOINTS.index("index_mcp_abduction")] = 0.1
    right = retarget(average_hand(0.18, "right"), joints, LOW, HIGH)
    left = retarget(average_hand(0.18, "left"), joints, LOW, HIGH)
    np.testing.assert_array_equal(left.joints_rad, right.joints_rad)


def test_a_robot_posture_as_a_whole_hand_couples_the_distal_joints_one_to_one() -> None:
    robot = np.random.default_rng(2).uniform(0.0, 1.0, (4, 15))
    joints = whole_robot_hand(robot)
    for finger in FINGERS:
        pip = JOINTS.index(f"{finger}_pip")
        np.testing.assert_array_equal(joints[:, pip], robot[:, ROBOT_JOINTS.index(f"{finger}_pip")])
        np.testing.assert_array_equal(joints[:, pip + 1], joints[:, pip])
    np.testing.assert_array_equal(joints[:, JOINTS.index("thumb_ip")], robot[:, 2])
    np.testing.assert_array_equal(joints[:, JOINTS.index("thumb_cmc_flexion")], 0.0)
