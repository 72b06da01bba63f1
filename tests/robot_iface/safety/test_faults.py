"""Each fault of the table, at its deadline, on a hand that moves."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

from robot_iface.types import DeviceState, SafetyState

CAT0, CAT1, HOLD, COMPLIANT = SafetyState.CAT0, SafetyState.CAT1, SafetyState.HOLD, SafetyState.COMPLIANT
JOINTS = range(3)


def active(rigid: Any, **hand: Any) -> Any:
    rig = rigid.Rig(ramp_s=0.05, **hand)
    rig.go_active()
    return rig


def spoil(rig: Any, joint: int | None = None, **fields: Any) -> None:
    """Falsify readings from now on."""

    def corrupt(state: DeviceState) -> DeviceState:
        changes = {}
        for name, value in fields.items():
            if joint is None:
                changes[name] = value
            else:
                changes[name] = getattr(state, name).copy()
                changes[name][joint] += value
        return dataclasses.replace(state, **changes)

    rig.hand.corrupt = corrupt


@pytest.mark.parametrize("joint", JOINTS)
@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("field", ["q_rad", "q_second_rad", "dq_rad_s", "tau_nm", "tau_interaction_nm"])
def test_a_state_that_is_not_finite_cuts_power_in_its_tick(
    rigid: Any, field: str, value: float, joint: int
) -> None:
    rig = active(rigid, q_rad=0.5)
    spoil(rig, joint, **{field: value})
    assert rig.ticks_until(CAT0, 1) == 1
    assert rig.causes() == ["state-not-finite"]
    assert rig.events()[0].joint == rigid.NAMES[joint]
    assert rig.hand.mode == "off"


@pytest.mark.parametrize("joint", JOINTS)
@pytest.mark.parametrize("value", [np.nan, np.inf])
@pytest.mark.parametrize("field", ["q_rad", "dq_rad_s", "tau_ff_nm", "stiffness_nm_rad", "damping_nms_rad"])
def test_a_command_that_is_not_finite_cuts_power_and_never_reaches_the_device(
    rigid: Any, field: str, value: float, joint: int
) -> None:
    rig = active(rigid)
    before = rig.hand.command

    def change(request: Any) -> Any:
        array = getattr(request, field).copy()
        array[joint] = value
        return dataclasses.replace(request, **{field: array})

    rig.change = change
    assert rig.ticks_until(CAT0, 1) == 1
    assert rig.causes() == ["command-not-finite"]
    assert rig.hand.command is before
    assert rig.hand.mode == "off"


@pytest.mark.parametrize("joint", JOINTS)
@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_sensors_that_differ_by_more_than_five_degrees(rigid: Any, joint: int, sign: float) -> None:
    rig = active(rigid)
    spoil(rig, joint, q_second_rad=sign * np.deg2rad(4.9))
    assert rig.run(50).safety_state is SafetyState.ACTIVE
    spoil(rig, joint, q_second_rad=sign * np.deg2rad(5.1))
    assert rig.ticks_until(CAT0, 1) == 1
    assert rig.causes() == ["sensors-differ"]
    assert rig.hand.mode == "off"


def test_the_stop_brakes_in_its_tick(rigid: Any) -> None:
    rig = active(rigid)
    rig.button.down = True
    assert rig.ticks_until(CAT1, 1) == 1
    assert (rig.causes(), rig.hand.mode) == (["e-stop"], "brake")


@pytest.mark.parametrize("joint", JOINTS)
@pytest.mark.parametrize("edge", ["low", "high"])
def test_a_joint_more_than_two_degrees_outside_its_range(rigid: Any, joint: int, edge: str) -> None:
    rig = active(rigid)
    bound = rig.limits.q_min_rad if edge == "low" else rig.limits.q_max_rad
    sign = -1.0 if edge == "low" else 1.0
    for degrees, trips in ((1.9, False), (2.1, True)):
        rig.hand.q[joint] = bound[joint] + sign * np.deg2rad(degrees)
        rig.supervisor._previous, rig.supervisor._continued = None, False
        state = rig.cycle().safety_state
        assert (state is CAT1) == trips
        rig.hand.dq[:] = 0.0
        rig.hand.ddq[:] = 0.0
    event = rig.events()[0]
    assert event.joint == rigid.NAMES[joint]
    assert event.value == pytest.approx(bound[joint] + sign * np.deg2rad(2.1)), "the angle itself, signed"
    assert event.bound == pytest.approx(bound[joint] + sign * np.deg2rad(2.0)), "and the end it has passed"
    assert (rig.causes(), rig.hand.mode) == (["range"], "brake")


@pytest.mark.parametrize("joint", JOINTS)
@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_trip_speed(rigid: Any, joint: int, sign: float) -> None:
    rig = active(rigid)
    spoil(rig, joint, dq_rad_s=sign * np.deg2rad(199.0))
    assert rig.run(1).safety_state is SafetyState.ACTIVE
    rig.supervisor._previous = None
    spoil(rig, joint, dq_rad_s=sign * np.deg2rad(201.0))
    assert rig.ticks_until(CAT1, 1) == 1
    assert rig.causes() == ["speed-trip"]


@pytest.mark.parametrize("joint", JOINTS)
@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_a_request_of_three_times_the_motor_cap(rigid: Any, joint: int, sign: float) -> None:
    rig = active(rigid)
    torque = np.zeros(3)
    torque[joint] = sign * 1.81
    rig.change = lambda request: dataclasses.replace(request, tau_ff_nm=torque)
    assert rig.ticks_until(CAT1, 1) == 1
    assert rig.causes() == ["torque-request"]


@pytest.mark.parametrize("joint", JOINTS)
@pytest.mark.parametrize("size", [0.055, 0.065, -0.055, -0.065])
def test_a_torque_step_over_the_rate(rigid: Any, joint: int, size: float) -> None:
    """60 Nm/s: 0.060 Nm in one tick of 1 ms."""
    rig = active(rigid)
    torque = np.zeros(3)
    torque[joint] = size
    rig.change = lambda request: dataclasses.replace(request, tau_ff_nm=torque)
    tripped = rig.cycle().safety_state is CAT1
    assert tripped == (abs(size) > 0.06)
    assert rig.causes() == (["torque-step"] if tripped else [])


@pytest.mark.parametrize("joint", JOINTS)
def test_power_over_the_limit(rigid: Any, joint: int) -> None:
    limits = dataclasses.replace(rigid.Rig().limits, power_w=0.05)
    rig = rigid.Rig(limits=limits, ramp_s=0.05)
    rig.go_active()
    rig.run(200)
    spoil(rig, joint, dq_rad_s=np.deg2rad(150.0))
    rig.supervisor._previous = None
    assert rig.ticks_until(CAT1, 1) == 1
    assert rig.causes() == ["power"]


@pytest.mark.parametrize("joint", JOINTS)
@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_interaction_over_the_limit_yields_within_30_ms_and_far_over_it_at_once(
    rigid: Any, joint: int, sign: float
) -> None:
    limit = float(rigid.Rig().limits.tau_interaction_nm[joint])
    for share, soonest, latest in ((1.1, 5, 30), (1.45, 5, 30), (1.55, 1, 1)):
        rig = active(rigid, q_rad=0.6)
        rig.run(100)
        spoil(rig, joint, tau_interaction_nm=sign * share * limit)
        assert soonest <= rig.ticks_until(COMPLIANT, latest) <= latest
        assert rig.causes() == ["load-hard" if share > 1.5 else "load"]
        assert np.all(rig.outcomes[-1].applied.stiffness_nm_rad == 0.0)


def test_a_load_that_comes_and_goes_does_not_add_up(rigid: Any) -> None:
    rig = active(rigid)
    for _ in range(20):
        spoil(rig, 0, tau_interaction_nm=0.28)
        rig.run(8)
        spoil(rig)
        rig.run(3)
    assert rig.causes() == []


@pytest.mark.parametrize(
    ("watch", "last_good", "first_bad", "state", "cause"),
    [
        ("heartbeat_age_ns", 250_000_000, 250_000_001, CAT1, "heartbeat-lost"),
        ("operator_age_ns", 1_000_000_000, 1_000_000_001, HOLD, "operator-silent"),
        ("camera_age_ns", 300_000_000, 300_000_001, HOLD, "camera-lost"),
        ("path_age_ns", 50_000_000, 50_000_001, HOLD, "path-stale"),
        ("overruns_in_row", 3, 4, CAT0, "overruns"),
        ("enable_held", True, False, HOLD, "enable-released"),
        ("path_fault", False, True, HOLD, "path-fault"),
        ("pain", False, True, HOLD, "pain"),
    ],
)
def test_what_the_loop_reports(
    rigid: Any, watch: str, last_good: Any, first_bad: Any, state: SafetyState, cause: str
) -> None:
    rig = active(rigid)
    assert rig.run(20, **{watch: last_good}).safety_state is SafetyState.ACTIVE
    assert rig.run(1, **{watch: first_bad}).safety_state is state
    assert rig.causes() == [cause]


def test_a_heartbeat_that_stops_brakes_by_252_ms(rigid: Any) -> None:
    rig = active(rigid)
    for age_ms in range(1, 253):
        rig.run(1, heartbeat_age_ns=age_ms * 1_000_000)
    assert (rig.supervisor.state, rig.causes()) == (CAT1, ["heartbeat-lost"])


def test_a_repetition_longer_than_its_time_out(rigid: Any) -> None:
    rig = active(rigid)
    assert rig.run(5, repetition_age_ns=10**9, repetition_timeout_ns=10**9).safety_state is SafetyState.ACTIVE
    assert rig.run(1, repetition_age_ns=10**9 + 1).safety_state is HOLD
    assert rig.causes() == ["repetition-time-out"]


@pytest.mark.parametrize(("ticks", "held"), [(49, False), (51, True)])
def test_a_loop_that_stood_still_for_more_than_50_ms_holds(rigid: Any, ticks: int, held: bool) -> None:
    """One long stall is one overrun; how long it was is seen in the time between two readings."""
    rig = active(rigid)
    rig.hand.tick += ticks
    assert (rig.cycle().safety_state is HOLD) == held
    assert rig.causes() == (["loop-stalled"] if held else [])


@pytest.mark.parametrize("field", ["t_ns", "seq"])
def test_a_device_that_repeats_itself_is_cut_off_in_three_periods(rigid: Any, field: str) -> None:
    rig = active(rigid)
    frozen = getattr(rig.states[-1], field)
    spoil(rig, **{field: frozen})
    assert rig.ticks_until(CAT0, 3) == 3
    assert rig.causes() == ["device-stale"]


@pytest.mark.parametrize(
    ("change", "cause"),
    [
        ({"faults": ("overload",)}, "device-fault overload"),
        ({"temperature_c": 81.0}, "temperature"),
        ({"temperature_c": float("nan")}, "temperature"),
    ],
)
def test_a_device_that_reports_a_fault_is_braked(rigid: Any, change: Any, cause: str) -> None:
    rig = active(rigid)
    spoil(rig, **change)
    assert rig.ticks_until(CAT1, 1) == 1
    assert rig.causes() == [cause]


@pytest.mark.parametrize("verb", ["read", "write"])
def test_a_device_that_fails_to_answer_is_cut_off(rigid: Any, verb: str, monkeypatch: Any) -> None:
    rig = active(rigid)

    def fail(*_: Any) -> None:
        raise OSError(5, "Input/output error")

    monkeypatch.setattr(rig.hand, verb, fail)
    assert rig.ticks_until(CAT0, 2) <= 2
    assert rig.causes() == ["device-lost Input/output error"]


def test_a_brake_that_fails_is_replaced_by_power_off(rigid: Any, monkeypatch: Any) -> None:
    rig = active(rigid)

    def fail(_: float) -> None:
        raise OSError(5, "Input/output error")

    monkeypatch.setattr(rig.hand, "brake", fail)
    rig.button.down = True
    assert rig.cycle().powered is False
    assert rig.hand.mode == "off"
