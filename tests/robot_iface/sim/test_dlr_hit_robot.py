"""The simulated DLR-HIT-Hand II as a robot: not worn, compensated, honest about its torque sensors."""

from __future__ import annotations

import numpy as np
import pytest

from robot_iface.kinematics.dlr_hit import FINGER_MAX_RAD, FINGER_MIN_RAD, finger_inverse, finger_points
from robot_iface.sim import DLR_HIT_JOINTS, SimulatedDlrHit, dlr_hit_capabilities
from robot_iface.types import JOINTS, CommandMode, DeviceCommand, Float64, Spasm

CAPABILITIES = dlr_hit_capabilities()
PIP = DLR_HIT_JOINTS.index("index_pip")


def going_to(goal_rad: Float64, gain_nm_rad: float = 0.4) -> DeviceCommand:
    gains, zeros = np.full(15, gain_nm_rad), np.zeros(15)
    return DeviceCommand(CommandMode.IMPEDANCE, goal_rad, zeros, zeros, gains, 0.07 * gains, 1)


def opened(pushes: tuple[Spasm, ...] = ()) -> SimulatedDlrHit:
    robot = SimulatedDlrHit(1, pushes=pushes)
    robot.open()
    robot.enable()
    return robot


def test_it_drives_abduction_and_two_flexions_of_five_digits_within_the_thesis_ranges() -> None:
    assert len(DLR_HIT_JOINTS) == 15
    assert set(DLR_HIT_JOINTS) < set(JOINTS)
    assert not CAPABILITIES.worn
    assert CAPABILITIES.chain == "dlr-hit-ii"
    assert CAPABILITIES.unpowered == "damped"
    for name, low, high in zip(DLR_HIT_JOINTS, CAPABILITIES.q_min_rad, CAPABILITIES.q_max_rad, strict=True):
        expected = (-15.0, 15.0) if name.endswith("abduction") else (0.0, 80.0)
        assert np.rad2deg([low, high]) == pytest.approx(expected)


def test_it_goes_where_it_is_told() -> None:
    rng = np.random.default_rng(4)
    low, high = CAPABILITIES.q_min_rad, CAPABILITIES.q_max_rad
    for _ in range(3):
        goal = rng.uniform(low + 0.05, high - 0.05)
        robot = opened()
        robot.write(going_to(goal))
        for _ in range(1500):
            robot.advance()
        np.testing.assert_allclose(robot.joints_rad, goal, atol=5e-3)


def test_gravity_is_compensated_and_free_air_pushes_nothing() -> None:
    robot = opened()
    start = robot.joints_rad
    for _ in range(1000):
        robot.advance()
        assert not robot.read().tau_interaction_nm.any()
    np.testing.assert_allclose(robot.joints_rad, start, atol=1e-3)


def test_a_push_is_felt_at_its_joint_with_its_sign() -> None:
    robot = opened((Spasm(0.1, 0.5, 0.08, "index_pip"),))
    robot.write(going_to(robot.joints_rad))
    for _ in range(300):
        robot.advance()
    state = robot.read()
    assert state.tau_interaction_nm[PIP] == -0.08, "the hand pushes back on what pushes it"
    assert not np.delete(state.tau_interaction_nm, PIP).any()
    assert state.tau_nm[PIP] == pytest.approx(-0.08, abs=5e-3), "at rest the motor carries it"


def test_without_power_gears_damp_what_power_lets_go() -> None:
    moved = []
    for powered in (True, False):
        robot = SimulatedDlrHit(1, pushes=(Spasm(0.0, 0.2, 0.03, "index_pip"),))
        robot.open()
        if powered:
            robot.enable()
        start = robot.joints_rad
        for _ in range(200):
            robot.advance()
        moved.append((robot.joints_rad - start)[PIP])
    assert 0.0 < moved[1] < 0.4 * moved[0]


def test_the_same_seed_reads_the_same_and_another_does_not() -> None:
    ends = []
    for seed in (2, 2, 3):
        robot = SimulatedDlrHit(seed)
        robot.advance()
        ends.append(robot.read().q_rad)
    assert ends[0].tobytes() == ends[1].tobytes() != ends[2].tobytes()


def test_from_joints_to_fingertip_and_back() -> None:
    joints = np.random.default_rng(6).uniform(FINGER_MIN_RAD, FINGER_MAX_RAD, (5000, 3))
    joints[:50, 2] = np.linspace(0.0, 0.05, 50)
    found = finger_inverse(finger_points(joints)[:, 3])
    assert np.abs(found - joints).max() < 1e-6


def test_its_patient_is_nobody() -> None:
    robot = opened()
    robot.patient.cue(np.zeros((2, 15)), 0.01, 1.0)
    robot.patient.progress(1.0)
    robot.patient.relax()
    robot.advance()
    assert not robot.read().tau_nm.any()
