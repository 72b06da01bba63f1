"""What every hand robot does, whatever it is made of."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import Protocol

import numpy as np
import pytest

from robot_iface.ports import HandRobot
from robot_iface.sim import SimulatedDlrHit, SimulatedExoskeleton
from robot_iface.types import JOINTS, CommandMode, DeviceCommand, PatientTwin


class TestableRobot(HandRobot, Protocol):
    """A hand robot and the passing of one of its periods."""

    __test__ = False

    def advance(self) -> None: ...


MAKERS: dict[str, Callable[[], TestableRobot]] = {
    "simulated exoskeleton": lambda: SimulatedExoskeleton(PatientTwin(), seed=1),
    "simulated DLR-HIT-Hand II": lambda: SimulatedDlrHit(seed=1),
}
"""Every implementation of the port; a new one adds its maker here."""


@pytest.fixture(params=sorted(MAKERS))
def robot(request: pytest.FixtureRequest) -> TestableRobot:
    return MAKERS[request.param]()


def push(robot: TestableRobot, torque_nm: float) -> DeviceCommand:
    joints = len(robot.capabilities.joint_names)
    zeros = np.zeros(joints)
    return DeviceCommand(CommandMode.TORQUE, zeros, zeros, np.full(joints, torque_nm), zeros, zeros, 1)


def test_it_has_every_verb_of_the_port(robot: TestableRobot) -> None:
    for name, verb in inspect.getmembers(HandRobot, inspect.isfunction):
        if not name.startswith("_"):
            assert (
                list(inspect.signature(getattr(robot, name)).parameters)
                == list(inspect.signature(verb).parameters)[1:]
            )


def test_capabilities_are_complete_and_consistent(robot: TestableRobot) -> None:
    capabilities = robot.capabilities
    joints = len(capabilities.joint_names)
    assert set(capabilities.joint_names) <= set(JOINTS)
    assert len(set(capabilities.joint_names)) == joints
    assert capabilities.q_min_rad.shape == capabilities.q_max_rad.shape == (joints,)
    assert (capabilities.q_min_rad < capabilities.q_max_rad).all()
    assert (capabilities.tau_max_nm > 0).all()
    assert capabilities.period_ns > 0


def test_every_reading_is_finite_counted_and_its_own(robot: TestableRobot) -> None:
    robot.open()
    first = robot.read()
    kept = first.q_rad.copy()
    for _ in range(5):
        robot.advance()
    second = robot.read()
    assert second.seq > first.seq
    assert second.t_ns > first.t_ns
    np.testing.assert_array_equal(first.q_rad, kept)
    for name in ("q_rad", "q_second_rad", "dq_rad_s", "tau_nm", "tau_interaction_nm"):
        column = getattr(second, name)
        assert column.shape == (len(robot.capabilities.joint_names),)
        assert np.isfinite(column).all()


def test_nothing_pushes_before_enable_or_after_power_off(robot: TestableRobot) -> None:
    robot.open()
    robot.write(push(robot, 0.05))
    robot.advance()
    assert not robot.read().tau_nm.any()
    robot.enable()
    robot.write(push(robot, 0.05))
    robot.advance()
    assert robot.read().tau_nm.min() > 0.0
    robot.power_off()
    robot.advance()
    assert not robot.read().tau_nm.any()


def test_motors_keep_their_cap(robot: TestableRobot) -> None:
    robot.open()
    robot.enable()
    robot.write(push(robot, 50.0))
    robot.advance()
    assert (robot.read().tau_nm <= robot.capabilities.tau_max_nm).all()


def test_the_brake_drops_the_goal_and_a_new_command_lifts_the_brake(robot: TestableRobot) -> None:
    robot.open()
    robot.enable()
    robot.write(push(robot, 0.1))
    for _ in range(20):
        robot.advance()
    moving = np.abs(robot.read().dq_rad_s).max()
    robot.brake(0.15)
    for _ in range(30):
        robot.advance()
    assert not robot.read().tau_nm.any()
    assert np.abs(robot.read().dq_rad_s).max() < 0.5 * moving
    robot.write(push(robot, 0.1))
    robot.advance()
    assert robot.read().tau_nm.min() > 0.0


def test_close_cuts_power(robot: TestableRobot) -> None:
    robot.open()
    robot.enable()
    robot.write(push(robot, 0.1))
    robot.close()
    robot.advance()
    assert not robot.read().tau_nm.any()


def test_a_command_without_power_is_forgotten(robot: TestableRobot) -> None:
    robot.open()
    robot.write(push(robot, 0.05))
    robot.enable()
    robot.advance()
    assert not robot.read().tau_nm.any()


def test_an_impedance_command_pulls_towards_its_goal(robot: TestableRobot) -> None:
    robot.open()
    robot.enable()
    state = robot.read()
    joints = len(robot.capabilities.joint_names)
    zeros, goal = np.zeros(joints), state.q_rad + 0.1
    gains = np.full(joints, 0.3)
    robot.write(DeviceCommand(CommandMode.IMPEDANCE, goal, zeros, zeros, gains, 0.1 * gains, 1))
    robot.advance()
    np.testing.assert_allclose(robot.read().tau_nm, 0.03, atol=2e-3)


def test_a_torque_command_leaves_nothing_of_the_spring_before_it(robot: TestableRobot) -> None:
    robot.open()
    robot.enable()
    joints = len(robot.capabilities.joint_names)
    zeros, gains = np.zeros(joints), np.full(joints, 0.3)
    goal = robot.read().q_rad + 0.1
    robot.write(DeviceCommand(CommandMode.IMPEDANCE, goal, zeros, zeros, gains, 0.1 * gains, 1))
    robot.advance()
    robot.write(push(robot, 0.02))
    robot.advance()
    np.testing.assert_array_equal(robot.read().tau_nm, np.full(joints, 0.02))
