"""Torque feedback (transparent) and opposition (resistive), as both laws give them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robot_iface.control import FingertipLaw, Goal, ImpedanceLaw, Law, hand_chain, thesis_gains
from robot_iface.kinematics import average_hand
from robot_iface.motion import PathState, QuinticPath, Setpoint
from robot_iface.safety import shipped_limits
from robot_iface.sim import DRIVEN, SimulatedExoskeleton, device_capabilities
from robot_iface.types import DeviceCommand, DeviceState, PatientTwin

J = len(DRIVEN)
DEVICE = device_capabilities()
LIMITS = shipped_limits(DRIVEN, DEVICE.q_min_rad, DEVICE.q_max_rad)
LIMIT = LIMITS.tau_interaction_nm
STILL = np.zeros(J)
AT = PathState(0.0, 0.0, 0.0, False)


@pytest.fixture(params=["joint", "fingertip"], name="law")
def law_fixture(request: pytest.FixtureRequest) -> Law:
    if request.param == "joint":
        return ImpedanceLaw(thesis_gains(DRIVEN), LIMITS)
    return FingertipLaw(hand_chain(DRIVEN, average_hand()), LIMITS)


def reading(dq: Any = 0.0, load: Any = 0.0) -> DeviceState:
    return DeviceState(0, 0, STILL + 0.5, STILL + 0.5, STILL + dq, STILL, STILL + load, 30.0, ())


def goal(multiple: float = 0.0, feedback: float = 0.0, opposition: float = 0.0, dq_d: float = 0.0) -> Goal:
    setpoint = Setpoint(STILL + 0.5, STILL + dq_d, STILL)
    return Goal(setpoint, STILL + multiple, STILL, AT, feedback, opposition)


def torque(command: DeviceCommand, state: DeviceState) -> np.ndarray:
    spring = command.stiffness_nm_rad * (command.q_rad - state.q_rad)
    return spring + command.damping_nms_rad * (command.dq_rad_s - state.dq_rad_s) + command.tau_ff_nm


def test_feedback_takes_its_share_of_a_steady_load(law: Law) -> None:
    load = 0.3 * LIMIT
    for seq in range(200):
        command = law.command(reading(load=load), goal(feedback=0.8), 1.0, seq)
    assert np.allclose(command.tau_ff_nm, -0.8 * load)
    for seq in range(200):
        command = law.command(reading(load=load), goal(), 1.0, seq)
    assert np.abs(command.tau_ff_nm).max() < 1e-12, "it goes when it is not asked for"


def test_feedback_is_bounded_in_size_and_rate_and_by_the_ramp(law: Law) -> None:
    """A load that jumps may not look like a torque step to the supervisor (60 Nm/s)."""
    last, steps = STILL, []
    for seq in range(100):
        command = law.command(reading(load=-0.9), goal(feedback=0.95), 0.5, seq)
        steps.append(command.tau_ff_nm - last)
        last = command.tau_ff_nm
    assert np.abs(steps).max() <= 20.0 * 1e-3 * 0.5 + 1e-12
    assert np.allclose(last, 0.5 * 0.5 * LIMIT)


def test_a_reading_that_is_no_number_leaves_the_feedback_clean(law: Law) -> None:
    law.command(reading(load=np.nan), goal(feedback=0.8), 1.0, 0)
    law.command(reading(load=np.inf), goal(feedback=0.8), 1.0, 1)
    assert np.all(law.command(reading(load=0.0), goal(feedback=0.8), 1.0, 2).tau_ff_nm == 0.0)


def test_feedback_of_one_and_more_is_not_given(law: Law) -> None:
    for seq in range(300):
        command = law.command(reading(load=0.01), goal(feedback=3.0), 1.0, seq)
    assert np.allclose(command.tau_ff_nm, -0.95 * 0.01)


@given(
    dq=st.floats(-8.0, 8.0),
    opposition=st.floats(0.05, 0.8),
    multiple=st.sampled_from([0.0, 0.3, 3.0]),
    dq_d=st.floats(-1.0, 1.0),
    ramp=st.floats(0.0, 1.0),
)
@settings(deadline=None)
def test_opposition_only_takes_energy_out(
    dq: float, opposition: float, multiple: float, dq_d: float, ramp: float
) -> None:
    """What it adds to the torque is o limit tanh(dq / v0) against the motion, whatever else is asked."""
    plain, opposed = (ImpedanceLaw(thesis_gains(DRIVEN), LIMITS) for _ in range(2))
    state = reading(dq=dq)
    before = torque(plain.command(state, goal(multiple, dq_d=dq_d), ramp, 0), state)
    command = opposed.command(state, goal(multiple, opposition=opposition, dq_d=dq_d), ramp, 0)
    added = torque(command, state) - before
    size = opposition * ramp * LIMIT
    v0 = np.maximum(0.1, size / 0.1)
    assert np.allclose(added, -size * np.tanh(dq / v0), atol=1e-8)
    assert np.all(added * dq <= 1e-8)
    assert command.damping_nms_rad.max() <= 0.1 + thesis_gains(DRIVEN).scaled(3.0).damping_nms_rad.max()
    assert np.all(np.abs(added) <= size + 1e-8)


def test_opposition_alone_never_has_the_sign_of_the_speed(law: Law) -> None:
    for dq in (-3.0, -0.01, 0.0, 1e-9, 0.5):
        state = reading(dq=dq)
        tau = torque(law.command(state, goal(opposition=0.8), 1.0, 0), state)
        assert np.all(tau * dq <= 0.0)


PATH_STEP_S = 0.005


def rms_interaction_nm(fist: Any, feedback: float) -> float:
    """A sound patient makes a fist of 22 degrees in two seconds, in a robot without stiffness."""
    robot = SimulatedExoskeleton(PatientTwin("healthy"), 1)
    robot.open()
    robot.enable()
    law = ImpedanceLaw(thesis_gains(DRIVEN), LIMITS)
    path = QuinticPath(fist())
    loads = []
    robot.patient.cue(path.sample(np.arange(0.0, path.duration_s, PATH_STEP_S)), PATH_STEP_S, 1.0)
    for tick in range(2500):
        robot.patient.progress(min(tick * 1e-3, path.duration_s))
        robot.advance()
        state = robot.read()
        robot.write(law.command(state, goal(feedback=feedback), 1.0, tick))
        loads.append(state.tau_interaction_nm)
    assert np.ptp(loads) > 0.0
    return float(np.sqrt(np.mean(np.square(loads[100:]))))


def test_a_sound_patient_hardly_feels_the_transparent_robot(fist: Any) -> None:
    plain, fed_back = rms_interaction_nm(fist, 0.0), rms_interaction_nm(fist, 0.8)
    assert fed_back < 0.6 * plain
    assert fed_back < 0.0033
