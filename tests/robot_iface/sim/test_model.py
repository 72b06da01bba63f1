"""The simulated hand is the hand of the kinematics, and its physics obeys its springs."""

from __future__ import annotations

import numpy as np
import pytest

from robot_iface.kinematics import DIP_PER_PIP, JOINT_MAX_RAD, JOINT_MIN_RAD, average_hand, forward
from robot_iface.sim import DRIVEN, build_model, device_capabilities, hand_landmarks, virtual_patient
from robot_iface.sim.engine import mujoco
from robot_iface.sim.model import STRAP_STIFFNESS_NM_RAD
from robot_iface.types import FINGERS, JOINTS, Side

CAPABILITIES = device_capabilities()
RANGE = (CAPABILITIES.q_min_rad, CAPABILITIES.q_max_rad)


@pytest.mark.parametrize("side", ["left", "right"])
@pytest.mark.parametrize("length_m", [0.15, 0.189, 0.22])
def test_mujoco_tree_agrees_with_forward_kinematics(side: Side, length_m: float) -> None:
    geometry = average_hand(length_m, side)
    hand = build_model(geometry, virtual_patient("healthy"), *RANGE)
    rng = np.random.default_rng(11)
    for joints in rng.uniform(JOINT_MIN_RAD, JOINT_MAX_RAD, (40, 21)):
        expected = forward(geometry, joints).landmarks_m[:20]
        np.testing.assert_allclose(hand_landmarks(hand, joints), expected, atol=1e-9)


def test_a_constant_motor_torque_stretches_strap_and_joint_in_series() -> None:
    patient = virtual_patient("mas2")
    hand = build_model(average_hand(), patient, *RANGE)
    data = mujoco.MjData(hand.model)
    data.qpos[hand.hand] = hand.rest_rad
    data.qpos[hand.robot] = data.qpos[hand.worn]
    start = data.qpos[hand.robot].copy()
    torque = 0.1
    data.qfrc_applied[hand.robot] = torque
    for _ in range(3000):
        mujoco.mj_step(hand.model, data)
    column = DRIVEN.index("index_mcp_flexion")
    expected = torque * (1 / patient.stiffness_nm_rad + 1 / STRAP_STIFFNESS_NM_RAD)
    assert (data.qpos[hand.robot] - start)[column] == pytest.approx(expected, rel=5e-3)


def test_distal_joints_follow_the_middle_ones_and_nothing_else_moves() -> None:
    hand = build_model(average_hand(), virtual_patient("healthy"), *RANGE)
    data = mujoco.MjData(hand.model)
    data.qpos[hand.hand] = hand.rest_rad
    data.qpos[hand.robot] = data.qpos[hand.worn]
    data.qfrc_applied[hand.robot[DRIVEN.index("index_pip")]] = 0.02
    for _ in range(2000):
        mujoco.mj_step(hand.model, data)
    joints = data.qpos[hand.hand]
    for finger in FINGERS:
        pip, dip = (joints[JOINTS.index(f"{finger}_{part}")] for part in ("pip", "dip"))
        assert dip == pytest.approx(DIP_PER_PIP * pip, abs=0.01)
    still = [index for index, name in enumerate(JOINTS) if not name.startswith("index")]
    np.testing.assert_allclose(joints[still], hand.rest_rad[still], atol=0.01)


def test_both_sides_move_alike() -> None:
    ends = []
    for side in ("left", "right"):
        hand = build_model(average_hand(side=side), virtual_patient("healthy"), *RANGE)
        data = mujoco.MjData(hand.model)
        data.qfrc_applied[hand.robot] = 0.03
        for _ in range(300):
            mujoco.mj_step(hand.model, data)
        ends.append(data.qpos[hand.hand].copy())
    np.testing.assert_allclose(ends[0], ends[1], atol=1e-9)
