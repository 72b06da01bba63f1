"""Laws of the hand's kinematics."""

from __future__ import annotations

import numpy as np
import pytest

from robot_iface.errors import Refused
from robot_iface.kinematics import (
    DIP_PER_PIP,
    JOINT_MAX_RAD,
    JOINT_MIN_RAD,
    average_hand,
    couple_dip,
    forward,
    jacobian,
)
from robot_iface.types import JOINTS, LANDMARKS, Float64, Side

SIDES: tuple[Side, ...] = ("left", "right")


def random_angles(count: int) -> Float64:
    return np.random.default_rng(7).uniform(JOINT_MIN_RAD, JOINT_MAX_RAD, (count, 21))


def test_straight_hand_has_its_length() -> None:
    straight = forward(average_hand(0.189), np.zeros(21)).landmarks_m
    assert straight[LANDMARKS.index("middle_tip")][2] == pytest.approx(0.189, abs=1e-12)


def test_bones_keep_their_length_in_every_pose() -> None:
    hand = average_hand()
    digits = forward(hand, random_angles(50)).landmarks_m[:, :20].reshape(50, 5, 4, 3)
    lengths = np.linalg.norm(np.diff(digits, axis=2), axis=-1)
    np.testing.assert_allclose(lengths, np.broadcast_to(hand.bones_m, lengths.shape), atol=1e-12)


def test_flexion_goes_to_palmar_and_abduction_to_the_thumb() -> None:
    hand = average_hand()
    tip = LANDMARKS.index("index_tip")
    for joint, axis in (
        ("index_mcp_flexion", 0),
        ("index_pip", 0),
        ("index_dip", 0),
        ("index_mcp_abduction", 1),
    ):
        angles = np.zeros(21)
        angles[JOINTS.index(joint)] = 0.3
        moved = forward(hand, angles).landmarks_m[tip] - forward(hand, np.zeros(21)).landmarks_m[tip]
        assert moved[axis] > 0.005, joint


def test_pip_angle_is_the_angle_between_its_bones() -> None:
    angles = np.zeros(21)
    angles[JOINTS.index("index_pip")] = np.deg2rad(40.0)
    points = forward(average_hand(), angles).landmarks_m
    mcp, pip, dip = (points[LANDMARKS.index(f"index_{part}")] for part in ("mcp", "pip", "dip"))
    cosine = (pip - mcp) @ (dip - pip) / np.linalg.norm(pip - mcp) / np.linalg.norm(dip - pip)
    assert np.arccos(cosine) == pytest.approx(np.deg2rad(40.0), abs=1e-9)


def test_left_hand_is_the_mirror_image() -> None:
    angles = random_angles(20)
    left, right = (forward(average_hand(side=side), angles) for side in SIDES)
    np.testing.assert_allclose(left.landmarks_m, right.landmarks_m * [1, -1, 1], atol=1e-15)


@pytest.mark.parametrize("side", SIDES)
def test_jacobian_agrees_with_finite_differences(side: Side) -> None:
    hand, step = average_hand(side=side), 1e-6
    for angles in random_angles(10):
        numeric = np.empty((25, 3, 21))
        for joint in range(21):
            shift = np.eye(21)[joint] * step
            ahead, behind = forward(hand, angles + shift), forward(hand, angles - shift)
            numeric[..., joint] = (ahead.landmarks_m - behind.landmarks_m) / (2 * step)
        np.testing.assert_allclose(jacobian(hand, angles), numeric, atol=1e-8)


def test_coupling_moves_only_the_dip_joints() -> None:
    angles = random_angles(5)
    coupled = couple_dip(angles)
    for index, joint in enumerate(JOINTS):
        expected = DIP_PER_PIP * angles[:, index - 1] if joint.endswith("_dip") else angles[:, index]
        np.testing.assert_allclose(coupled[:, index], expected)


@pytest.mark.parametrize("length_m", [0.0, 0.09, 0.3, np.nan])
def test_a_length_that_no_hand_has_is_refused(length_m: float) -> None:
    with pytest.raises(Refused, match="hand length"):
        average_hand(length_m)
