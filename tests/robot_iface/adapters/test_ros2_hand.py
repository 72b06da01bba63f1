"""The real hand keeps the contract of every hand robot, and refuses a device that is not as it should be."""

from __future__ import annotations

import inspect
import time
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

from robot_iface.adapters import ros2_hand
from robot_iface.adapters.ros2_hand import Ros2Hand
from robot_iface.errors import Refused
from robot_iface.ports import HandRobot
from robot_iface.sim import DRIVEN
from robot_iface.types import CommandMode, DeviceCommand, DeviceState

StandIn = Callable[..., tuple[Any, Any]]


@pytest.fixture
def hand_of(stand_in: StandIn) -> Iterator[Callable[..., tuple[Ros2Hand, Any]]]:
    """Opens a hand at a stand-in; it is closed with the test."""
    opened: list[Ros2Hand] = []

    def open_one(command: str = "effort", **options: Any) -> tuple[Ros2Hand, Any]:
        device, process = stand_in(command, **options)
        hand = Ros2Hand(device)
        opened.append(hand)
        hand.open()
        return hand, process

    yield open_one
    for hand in opened:
        hand.close()


def readings(hand: Ros2Hand, count: int) -> DeviceState:
    """Wait for so many new readings."""
    first = hand.read().seq
    end_s = time.monotonic() + 30.0
    while hand.read().seq < first + count:
        assert time.monotonic() < end_s, "the device fell silent"
        time.sleep(0.002)
    return hand.read()


def push(torque_nm: float, joints: int = len(DRIVEN)) -> DeviceCommand:
    zeros = np.zeros(joints)
    return DeviceCommand(CommandMode.TORQUE, zeros, zeros, np.full(joints, torque_nm), zeros, zeros, 1)


def keep_pushing(hand: Ros2Hand, torque_nm: float, count: int) -> DeviceState:
    for _ in range(count):
        hand.write(push(torque_nm))
        state = readings(hand, 1)
    return state


def test_it_has_every_verb_of_the_port() -> None:
    for name, verb in inspect.getmembers(HandRobot, inspect.isfunction):
        if not name.startswith("_"):
            given = list(inspect.signature(getattr(Ros2Hand, name)).parameters)
            assert given == list(inspect.signature(verb).parameters)


def test_readings_are_counted_whole_and_in_our_signs_and_zeros(hand_of: Any) -> None:
    hand, _ = hand_of(start_deg=8.0)
    first = hand.read()
    second = readings(hand, 3)
    assert second.seq >= first.seq + 3
    assert second.t_ns > first.t_ns
    assert hand.read() is hand.read()
    assert np.rad2deg(second.q_rad) == pytest.approx(8.0)
    np.testing.assert_array_equal(second.q_rad, second.q_second_rad)
    for name in ("q_rad", "q_second_rad", "dq_rad_s", "tau_nm", "tau_interaction_nm"):
        column = getattr(second, name)
        assert column.shape == (len(DRIVEN),)
        assert np.isfinite(column).all()


def test_nothing_pushes_before_enable_or_after_power_off(hand_of: Any) -> None:
    hand, process = hand_of(watchdog_s=1.0)
    readings(hand, 10)
    hand.write(push(0.05))
    hand.brake(0.15)
    assert not readings(hand, 5).tau_nm.any()
    hand.enable()
    assert keep_pushing(hand, 0.05, 3).tau_nm == pytest.approx(0.05)
    hand.power_off()
    readings(hand, 2)
    for _ in range(60):  # what is said again without power must not be a new enable
        assert not hand.read().tau_nm.any()
        time.sleep(0.002)
    events = [line["event"] for line in process.ended()]
    assert events == ["ready", "on by command", "off by command"]


def test_motors_keep_their_cap_and_no_number_is_no_command(hand_of: Any) -> None:
    hand, _ = hand_of(watchdog_s=1.0, damping_nms_rad=2.0)
    hand.enable()
    assert keep_pushing(hand, 50.0, 3).tau_nm == pytest.approx(0.6)
    with pytest.raises(OSError, match="no number"):
        hand.write(push(float("nan")))


@pytest.mark.parametrize("command", ["effort", "trajectory"])
def test_the_brake_drops_the_goal_and_a_new_command_lifts_the_brake(command: str, hand_of: Any) -> None:
    hand, _ = hand_of(command, watchdog_s=1.0, damping_nms_rad=0.01)
    hand.enable()
    moving = np.abs(keep_pushing(hand, 0.05, 8).dq_rad_s).max()
    hand.brake(0.15)
    braked = readings(hand, 12)
    assert np.abs(braked.dq_rad_s).max() < 0.5 * moving
    assert (braked.tau_nm * braked.dq_rad_s <= 1e-6).all(), "the brake pushes"
    assert keep_pushing(hand, 0.05, 3).tau_nm.min() > 0.0


def test_the_impedance_law_holds_a_goal(hand_of: Any) -> None:
    hand, _ = hand_of(watchdog_s=1.0)
    hand.enable()
    ones = np.ones(len(DRIVEN))
    goal = np.deg2rad(16.0) * ones
    for _ in range(60):
        hand.write(
            DeviceCommand(CommandMode.IMPEDANCE, goal, 0.0 * ones, 0.0 * ones, 0.9 * ones, 0.03 * ones, 1)
        )
        state = readings(hand, 1)
    assert np.rad2deg(state.q_rad) == pytest.approx(16.0, abs=2.0)
    assert keep_pushing(hand, 0.05, 3).tau_nm == pytest.approx(0.05), "the goal is still pursued"


def test_a_driver_that_has_switched_itself_off_stays_off(hand_of: Any) -> None:
    hand, process = hand_of(watchdog_s=0.1)
    hand.enable()
    process.wait_for("event", "off by watchdog")
    hand.write(push(0.05))
    assert not readings(hand, 30).tau_nm.any()
    hand.power_off()
    readings(hand, 2)
    hand.enable()
    assert process.wait_for("event", "on by command")


def test_faults_are_reported_and_cleared(hand_of: Any) -> None:
    hand, _ = hand_of(fault="over-current, encoder 2")
    assert readings(hand, 3).faults == ("over-current", "encoder 2")
    hand.clear_faults()
    assert readings(hand, 5).faults == ()


def test_close_cuts_power_and_gives_the_device_back(hand_of: Any) -> None:
    hand, process = hand_of(watchdog_s=1.0)
    hand.enable()
    hand.write(push(0.05))
    process.wait_for("event", "on by command")
    hand.close()
    process.wait_for("event", "off by command")
    with pytest.raises(OSError, match="not open"):
        hand.read()
    with pytest.raises(Refused, match="is not open"):
        hand.enable()
    hand.open()
    assert readings(hand, 2).seq > 0


def test_a_second_client_is_refused(hand_of: Any) -> None:
    hand, _ = hand_of(watchdog_s=1.0)
    second = Ros2Hand(hand.device)
    with pytest.raises(Refused, match="in use by another process"):
        second.open()
    assert readings(hand, 2).seq > 0


def read_on(hand: Ros2Hand, seconds: float) -> None:
    end_s = time.monotonic() + seconds
    while time.monotonic() < end_s:
        hand.read()
        time.sleep(0.002)


def test_joints_that_vanish_in_mid_run_are_a_lost_device_never_a_traceback(hand_of: Any) -> None:
    hand, process = hand_of(vanish=True, watchdog_s=1.0)
    with pytest.raises(OSError, match="without"):
        read_on(hand, 10.0)
    assert process.process.poll() is None


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"silent": True}, "silent for"),
        ({"deaf": True}, "listens to neither command nor power"),
        ({"rename": "motor_x"}, "without motor_0"),
        ({"no_velocity": True}, "without velocity of every joint"),
        ({"rival": True}, "commanded by somebody else"),
    ],
)
def test_a_device_that_is_not_what_it_should_be_is_refused(
    options: dict[str, Any], sentence: str, stand_in: StandIn, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(ros2_hand, "ANSWER_S", 2.0)
    device, process = stand_in(**options)
    for _ in range(2):  # a refused device is given back
        with pytest.raises(Refused, match=sentence):
            Ros2Hand(device).open()
    assert process.process.poll() is None
