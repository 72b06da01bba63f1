"""Planted faults: each shows what it says, when it says so, on either simulated device."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np
import pytest

from robot_iface.errors import Refused
from robot_iface.sim import Fault, FaultKind, SimulatedDlrHit, SimulatedExoskeleton
from robot_iface.types import CommandMode, DeviceCommand, DeviceState, PatientTwin

Device = SimulatedExoskeleton | SimulatedDlrHit
Maker = Callable[[Iterable[Fault]], Device]
JOINT = "index_pip"


def exoskeleton(faults: Iterable[Fault]) -> Device:
    return SimulatedExoskeleton(PatientTwin("healthy"), 1, faults)


def dlr_hit(faults: Iterable[Fault]) -> Device:
    return SimulatedDlrHit(1, faults)


@pytest.fixture(params=[exoskeleton, dlr_hit])
def make(request: pytest.FixtureRequest) -> Maker:
    maker: Maker = request.param
    return maker


def readings(device: Device, ticks: int) -> list[DeviceState]:
    device.open()
    states = []
    for _ in range(ticks):
        device.advance()
        states.append(device.read())
    return states


def shown(kind: FaultKind, state: DeviceState, clean: DeviceState, joint: int) -> bool:
    match kind:
        case "nan":
            return bool(np.isnan(state.q_rad[joint]))
        case "inf":
            return bool(np.isinf(state.q_rad[joint]))
        case "sensor-offset":
            return bool(abs(state.q_rad[joint] - state.q_second_rad[joint]) > 0.1)
        case "wrong-sign":
            return bool(state.q_rad[joint] * clean.q_rad[joint] < 0.0 and state.q_second_rad[joint] < 0.0)
        case "over-temperature":
            return state.temperature_c == 0.2
        case _:
            return state.faults != ()


@pytest.mark.parametrize(
    "kind", ["nan", "inf", "sensor-offset", "wrong-sign", "over-temperature", "device-fault"]
)
def test_a_planted_fault_comes_and_goes_at_its_joint_only(make: Maker, kind: FaultKind) -> None:
    device = make([Fault(kind, 0.1, 0.1, JOINT, 0.2)])
    names = device.capabilities.joint_names
    joint, others = names.index(JOINT), [i for i, name in enumerate(names) if name != JOINT]
    for tick, (state, clean) in enumerate(
        zip(readings(device, 300), readings(make([]), 300), strict=True), 1
    ):
        assert shown(kind, state, clean, joint) == (100 <= tick < 200)
        np.testing.assert_allclose(state.q_rad[others], clean.q_rad[others], atol=0.01)


def test_a_frozen_device_repeats_its_last_reading(make: Maker) -> None:
    sequence = [state.seq for state in readings(make([Fault("freeze", 0.1, 0.1)]), 300)]
    assert sequence[:100] == list(range(1, 101))
    assert set(sequence[100:199]) == {100}
    assert sequence[199:] == list(range(200, 301))


def test_a_delayed_reading_counts_on_but_is_old(make: Maker) -> None:
    states = readings(make([Fault("delayed", 0.1, 0.1, size=4)]), 300)
    sequence = np.array([state.seq for state in states])
    late = np.arange(1, 301) - sequence
    assert not late[:99].any()
    assert (late[110:198] == 4).all()
    assert not late[200:].any()
    assert (np.diff(sequence) >= 0).all()


def test_reading_twice_in_a_period_makes_a_late_line_no_later(make: Maker) -> None:
    device = make([Fault("delayed", 0.0, size=4)])
    device.open()
    for tick in range(1, 51):
        device.advance()
        first, second = device.read(), device.read()
        assert first.seq == second.seq == max(tick - 4, 1)


@pytest.mark.parametrize(("burst", "longest"), [(0, 1), (1, 1), (3, 3), (10, 10)])
def test_lost_readings_are_repeated_ones(make: Maker, burst: int, longest: int) -> None:
    sequence = [state.seq for state in readings(make([Fault("lost", 0.1, 0.1, size=burst)]), 300)]
    ages = np.arange(1, 301) - np.array(sequence)
    assert ages.max() == longest
    assert not ages[:98].any()
    assert not ages[200:].any()


def test_reordered_readings_all_arrive_but_not_in_turn(make: Maker) -> None:
    sequence = np.array([state.seq for state in readings(make([Fault("reordered", 0.1, 0.1)]), 300)])
    steps = np.diff(sequence)
    assert (steps[:97] == 1).all()
    assert (steps[100:197] < 0).any()
    assert len(set(sequence[102:196].tolist())) == 94
    assert (steps[200:] == 1).all()


def test_a_stuck_sensor_stays_while_its_twin_moves(make: Maker) -> None:
    device = make([Fault("stuck", 0.05, joint=JOINT)])
    joint = device.capabilities.joint_names.index(JOINT)
    device.open()
    device.enable()
    zeros = np.zeros(len(device.capabilities.joint_names))
    device.write(DeviceCommand(CommandMode.TORQUE, zeros, zeros, zeros + 0.05, zeros, zeros, 1))
    states = []
    for _ in range(200):
        device.advance()
        states.append(device.read())
    stuck = np.array([state.q_rad[joint] for state in states[50:]])
    twin = np.array([state.q_second_rad[joint] for state in states[50:]])
    assert np.ptp(stuck) == 0.0
    assert np.ptp(twin) > 0.1
    assert not np.array([state.dq_rad_s[joint] for state in states[50:]]).any()


def test_a_wrong_sign_drives_the_device_away_from_its_goal(make: Maker) -> None:
    faults: tuple[tuple[Fault, ...], ...] = ((), (Fault("wrong-sign", 0.0, joint=JOINT),))
    ends = []
    for planted in faults:
        device = make(planted)
        names = device.capabilities.joint_names
        joint, zeros = names.index(JOINT), np.zeros(len(names))
        device.open()
        device.enable()
        gains = np.where(zeros + 1 > 0, 0.3, 0.0)
        goal = device.read().q_rad
        device.write(DeviceCommand(CommandMode.IMPEDANCE, goal + 0.05, zeros, zeros, gains, 0.05 * gains, 1))
        before = float(device.read().q_second_rad[joint])
        for _ in range(300):
            device.advance()
        ends.append(float(device.read().q_second_rad[joint]) - before)
    assert abs(ends[0]) < 0.1
    assert abs(ends[1]) > 0.3


def test_a_reversed_torque_sensor_feels_the_opposite() -> None:
    loads = []
    for kind in ("wrong-sign-interaction", "over-temperature"):
        spasm = Fault("spasm", 0.0, joint=JOINT, size=0.1)
        device = SimulatedExoskeleton(PatientTwin("healthy"), 1, [spasm, Fault(kind, 0.0, joint=JOINT)])
        state = readings(device, 30)[-1]
        loads.append(state.tau_interaction_nm[device.capabilities.joint_names.index(JOINT)])
    assert loads[0] == -loads[1] != 0.0


def test_a_line_that_fails_fails_as_a_line_does(make: Maker) -> None:
    device = make([Fault("read-error", 0.1, 0.1), Fault("write-error", 0.3, 0.1)])
    device.open()
    zeros = np.zeros(len(device.capabilities.joint_names))
    command = DeviceCommand(CommandMode.TORQUE, zeros, zeros, zeros, zeros, zeros, 1)
    failed: dict[str, list[int]] = {"read": [], "write": []}
    for tick in range(500):
        try:
            device.read()
        except OSError:
            failed["read"].append(tick)
        try:
            device.write(command)
        except OSError:
            failed["write"].append(tick)
        device.advance()
    assert failed == {"read": list(range(100, 200)), "write": list(range(300, 400))}


def test_faults_do_not_hide_one_another(make: Maker) -> None:
    device = make(
        [Fault("over-temperature", 0.0, size=90.0), Fault("nan", 0.0, joint=JOINT), Fault("freeze", 0.05)]
    )
    last = readings(device, 100)[-1]
    assert last.seq == 50
    assert last.temperature_c == 90.0
    assert np.isnan(last.q_rad).sum() == 1


def test_a_fault_of_a_joint_that_the_device_has_not_is_refused(make: Maker) -> None:
    with pytest.raises(Refused, match=r"joint of the fault nan.*index_toe"):
        make([Fault("nan", 0.0, joint="index_toe")])
