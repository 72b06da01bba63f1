"""Hazard 1: a movement of one side is played on the other as its mirror image and is for that side."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rehab_app.recording.take import HandMotion
from rehab_app.therapy.reference import build_reference
from robot_iface.build import capabilities
from robot_iface.kinematics import average_hand, couple_dip, forward
from robot_iface.safety import shipped_limits
from robot_iface.types import ReferencePath, Side
from sessions.records import JOINTS, Status

DEVICE = capabilities("exoskeleton")
TIPS = [3, 7, 11, 15, 19]


def take(side: Side) -> HandMotion:
    """One and the same movement, shown by a hand of a side: its points are mirrored, its angles are not."""
    t_s = np.arange(0.0, 6.0, 1.0 / 30.0)
    joints = np.zeros((t_s.size, 21))
    closed = 0.5 * (1.0 - np.cos(2.0 * np.pi * t_s / 6.0))
    for row, name in enumerate(JOINTS):
        if name.endswith(("mcp_flexion", "pip")):
            joints[:, row] = 0.1 + (0.2 + 0.01 * row) * closed
    joints = couple_dip(joints)
    geometry = average_hand(side=side)
    return HandMotion(
        t_ns=np.round(1e9 * t_s).astype(np.int64),
        t_s=t_s,
        joints_rad=joints,
        joint_covariance_rad2=np.tile(0.01**2 * np.eye(21), (t_s.size, 1, 1)),
        joint_status=np.full(joints.shape, Status.MEASURED, dtype=np.uint8),
        fingertips_palm_m=forward(geometry, joints).landmarks_m[:, TIPS],
        p_camera_palm_m=np.zeros((t_s.size, 3)),
        q_camera_palm_wxyz=np.tile([1.0, 0.0, 0.0, 0.0], (t_s.size, 1)),
        residual_m=np.zeros(t_s.size),
        side=side,
        geometry=geometry,
    )


def path(shown: HandMotion, patient: Side) -> ReferencePath:
    return build_reference(
        shown,
        patient_geometry=average_hand(0.18, patient),
        patient_side=patient,
        driven_joints=DEVICE.joint_names,
        limits=shipped_limits(DEVICE.joint_names, DEVICE.q_min_rad, DEVICE.q_max_rad),
        take_digest="0" * 64,
        device=DEVICE,
    ).path


@pytest.mark.parametrize("shown", ["left", "right"])
@pytest.mark.parametrize("patient", ["left", "right"])
def test_the_path_is_for_the_patients_side_and_the_movement_the_same(shown: Side, patient: Side) -> None:
    made = path(take(shown), patient)
    assert made.side == patient
    np.testing.assert_allclose(made.q_rad, path(take("right"), "right").q_rad, atol=1e-9)


def test_fingertips_of_the_two_sides_are_mirror_images() -> None:
    right, left = take("right"), take("left")
    np.testing.assert_allclose(left.fingertips_palm_m, right.fingertips_palm_m * [1.0, -1.0, 1.0], atol=1e-12)
    angles = replace(right, side="left").joints_rad
    np.testing.assert_array_equal(left.joints_rad, angles)
