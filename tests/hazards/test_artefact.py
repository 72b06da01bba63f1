"""Hazard 15: an artefact is reported as recovery. Device end, spasm and recoil are not ability."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rehab_app.services.assessed import device_ends
from robot_iface.motion.limits import SweepResult
from robot_iface.runtime.sweep_reading import DEVICE_END_RAD, measured_range
from robot_iface.safety import shipped_limits
from robot_iface.sim import DRIVEN, device_capabilities
from robot_iface.types import Float64, PhaseChange, SafetyState, Sweep, TickBlock
from sessions.metrics.effort import robot_share, work
from sessions.metrics.motion_range import joint_range

DEVICE = device_capabilities()
LIMITS = shipped_limits(DRIVEN, DEVICE.q_min_rad, DEVICE.q_max_rad)
JOINTS = len(DRIVEN)
TICK_NS = 10_000_000
PART = 120
"""Ticks of each part: the approach, then what the patient did alone, then what the device reached."""
SWEEP = Sweep("range", DRIVEN, "right", ("fist",), np.full((1, JOINTS), 0.5))


def phase(part: int, name: str, starter: str, repetition: int) -> PhaseChange:
    return PhaseChange(part * PART * TICK_NS, repetition, name, starter, 0.0, 0.0, np.ones(JOINTS))


PHASES = (
    phase(0, "approach", "", -1),
    phase(1, "fist", "patient", 0),
    phase(2, "fist", "robot", 0),
    phase(3, "done", "", 0),
)


def block(passive_rad: Float64, load_nm: Float64, alone_rad: Float64 | None = None) -> TickBlock:
    """The ticks of a sweep of one posture."""
    alone = np.full(JOINTS, 0.3) if alone_rad is None else alone_rad
    q = np.repeat(np.stack((np.full(JOINTS, 0.3), alone, passive_rad)), PART, axis=0)
    load = np.repeat(np.stack((np.zeros(JOINTS), np.zeros(JOINTS), load_nm)), PART, axis=0)
    ticks, still = 3 * PART, np.zeros((3 * PART, JOINTS))
    states = np.full(ticks, SafetyState.ACTIVE, dtype=np.uint8)
    times = np.arange(ticks, dtype=np.int64) * TICK_NS
    scalar = np.zeros(ticks)
    return TickBlock(times, q, still, still, load, scalar, scalar, states, *[still] * 8)


def read(ticks: TickBlock) -> SweepResult:
    return measured_range((ticks,), PHASES, SWEEP, LIMITS, DEVICE)


@settings(max_examples=60, deadline=None)
@given(
    st.lists(st.floats(0.0, 1.0), min_size=JOINTS, max_size=JOINTS),
    st.lists(st.floats(-0.99, 0.99), min_size=JOINTS, max_size=JOINTS),
)
def test_the_end_of_the_device_is_never_the_patients(shares: list[float], loads: list[float]) -> None:
    passive = DEVICE.q_min_rad + np.array(shares) * (DEVICE.q_max_rad - DEVICE.q_min_rad)
    result = read(block(passive, np.array(loads) * LIMITS.tau_interaction_nm))
    near = np.minimum(passive - DEVICE.q_min_rad, DEVICE.q_max_rad - passive)
    assert not (result.device_end & result.patient_end).any()
    assert result.device_end[0][near < DEVICE_END_RAD - 1e-9].all()
    assert not result.device_end[0][near > DEVICE_END_RAD + 1e-9].any()
    assert len(device_ends(result)) == int(result.device_end.sum())


@pytest.mark.parametrize("ends_high", [True, False])
def test_it_is_printed_as_a_bound_and_not_as_a_value(ends_high: bool) -> None:
    mcp = DRIVEN.index("index_mcp_flexion")
    passive = np.full(JOINTS, 0.3)
    passive[mcp] = DEVICE.q_max_rad[mcp] if ends_high else DEVICE.q_min_rad[mcp]
    (sentence,) = device_ends(read(block(passive, np.zeros(JOINTS))))
    degrees = f"{np.rad2deg(passive[mcp]):.0f} degrees"
    bound = f"at least {degrees}" if ends_high else f"{degrees} or less"
    assert sentence == f"index_mcp_flexion in fist: {bound}, device limit."


@pytest.mark.parametrize("joint", [0, 5, 11])
def test_what_a_spasm_did_is_no_range(joint: int) -> None:
    """A load over the limit in the last second: neither an end of the patient's nor of the device's."""
    passive, calm = np.full(JOINTS, 0.6), np.zeros(JOINTS)
    assert read(block(passive, calm)).passive_rad[0] == pytest.approx(passive)
    spasm = calm.copy()
    spasm[joint] = -1.1 * LIMITS.tau_interaction_nm[joint]
    result = read(block(passive, spasm))
    assert np.isnan(result.passive_rad).all()
    assert not result.patient_end.any()
    assert not result.device_end.any()


@pytest.mark.parametrize("state", [SafetyState.HOLD, SafetyState.COMPLIANT, SafetyState.CAT1])
def test_what_the_supervisor_had_to_end_is_no_range(state: SafetyState) -> None:
    ticks = block(np.full(JOINTS, 0.6), np.zeros(JOINTS))
    states = ticks.safety_state.copy()
    states[-20:] = state
    result = read(replace(ticks, safety_state=states))
    assert np.isnan(result.passive_rad).all()
    assert result.active_rad[0] == pytest.approx(np.full(JOINTS, 0.3)), "the part before it stays"


def test_recoil_of_stiff_tissue_is_not_called_effort() -> None:
    """A spring alone: half of the work comes back. It is printed between its bounds, never as strength."""
    t_s = np.arange(0.0, 6.0, 0.001)
    angle = 0.5 * (1.0 - np.cos(2.0 * np.pi * t_s / 3.0))
    share = robot_share([work(t_s, 0.2 * angle, np.gradient(angle, 0.001))], 0.1, 1.0)
    assert share.interval is not None
    assert share.interval[1] == pytest.approx(1.0, abs=0.01), "that the robot did all of it stays possible"
    assert "not separable" in share.reason


@pytest.mark.parametrize("std_deg", [1.0, 4.0])
def test_the_error_of_the_sensors_is_in_the_interval_of_every_range(std_deg: float) -> None:
    """Two measurements of one hand agree within the interval in 95 % of cases: that is no recovery."""
    rng = np.random.default_rng(15)
    t_s = np.arange(0.0, 4.0, 1.0 / 60.0)
    truth = np.deg2rad(20.0 + 40.0 * np.sin(2.0 * np.pi * t_s / 4.0))
    errors, inside = np.deg2rad(rng.normal(0.0, std_deg, (200, 2))), 0
    for low_error, high_error in errors:
        shown = truth + np.where(truth > np.deg2rad(20.0), high_error, low_error)
        width = joint_range(t_s, shown, np.full(t_s.size, np.deg2rad(std_deg))).width
        assert width.interval is not None
        inside += width.interval[0] <= np.deg2rad(80.0) <= width.interval[1]
    assert inside / 200 >= 0.9
