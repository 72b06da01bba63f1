"""Hazard 7: a strap slips in mid-session, angles become false, joints are sheared."""

from __future__ import annotations

import numpy as np
import pytest

from robot_iface.build import open_rig
from robot_iface.runtime import ScriptedInbox, Surroundings, perform
from robot_iface.runtime.drift import Drift, NeutralDrift
from robot_iface.safety import shipped_limits
from robot_iface.sim import DRIVEN, device_capabilities
from robot_iface.types import (
    DeviceState,
    Mode,
    PatientTwin,
    Plan,
    Prescription,
    ReferencePath,
    SafetyEvent,
    SafetyState,
    VirtualKind,
)

SLIP_AT_S = 9.0


class NeverPressed:
    def pressed(self) -> bool:
        return False


def drifts(kind: VirtualKind, mode: Mode, slip_deg: float, repetitions: int) -> list[SafetyEvent]:
    """Every "fit-drift" of a run in which all straps slip by so much after 9 s."""
    t_s = np.linspace(0.0, 1.5, 46)
    closing = 0.5 - 0.5 * np.cos(2.0 * np.pi * t_s / 1.5)
    q = np.deg2rad(10.0 + 8.0 * closing[:, None] * np.ones(12))
    path = ReferencePath(DRIVEN, t_s, q, "0" * 64, "right")
    device = device_capabilities()
    limits = shipped_limits(DRIVEN, device.q_min_rad, device.q_max_rad)
    ordered = Prescription(mode, repetitions=repetitions, cue_timeout_s=1.0)
    twin = PatientTwin(kind, strap_slip_rad=float(np.deg2rad(slip_deg)), slip_at_s=SLIP_AT_S)
    plan = Plan("exoskeleton", path, ordered, limits, twin, 3, "0")
    heard: list[object] = []
    perform(plan, open_rig(plan), Surroundings(NeverPressed(), heard.append, ScriptedInbox()))
    return [item for item in heard if isinstance(item, SafetyEvent) and item.cause == "fit-drift"]


@pytest.mark.parametrize(
    ("kind", "mode"), [("healthy", "passive"), ("mas2", "passive"), ("weak", "assistive")]
)
def test_straps_that_slip_by_ten_degrees_hold_the_run(kind: VirtualKind, mode: Mode) -> None:
    (event,) = drifts(kind, mode, 10.0, 6)
    assert event.state == SafetyState.HOLD
    assert event.joint in DRIVEN
    assert np.rad2deg(event.value) == pytest.approx(10.0, abs=2.0)
    assert np.rad2deg(event.bound) == pytest.approx(8.0)
    assert event.t_ns * 1e-9 < SLIP_AT_S + 25.0


@pytest.mark.parametrize(
    ("kind", "mode"), [("tremor", "passive"), ("slacking", "assistive"), ("clonus", "assistive")]
)
def test_straps_that_hold_or_slip_by_less_than_the_bound_do_not(kind: VirtualKind, mode: Mode) -> None:
    assert drifts(kind, mode, 4.0, 4) == []


def judged(
    drift: NeutralDrift, stiffness: float, neutral_deg: float, bias_nm: float = 0.0, swing_deg: float = 10.0
) -> Drift | None:
    """One repetition of a passive joint that is moved by so much; what is judged of it."""
    zeros = np.zeros(1)
    for tick in range(3000):
        q = np.full(1, np.deg2rad(20.0 + swing_deg * np.sin(tick / 400.0)))
        speed = np.full(1, np.deg2rad(swing_deg / 0.4 * np.cos(tick / 400.0)))
        load = stiffness * (q - np.deg2rad(neutral_deg)) + 0.002 * speed - bias_nm
        drift.watch(DeviceState(0, 0, q, q, speed, zeros, load, 30.0, ()), quiet=True)
    return drift.judge()


def test_tone_is_no_drift_a_spasm_passes_and_a_slip_stays() -> None:
    drift = NeutralDrift(1, 1e-3)
    assert judged(drift, 0.1, 30.0) is None
    for stiffness in (0.05, 0.3, 0.6):
        assert judged(drift, stiffness, 30.0) is None, "tone rises and falls"
    assert judged(drift, 0.1, 30.0, bias_nm=0.1) is None, "a spasm through one repetition"
    assert judged(drift, 0.1, 30.0) is None
    assert judged(drift, 0.1, 40.0) is None
    found = judged(drift, 0.1, 40.0)
    assert found is not None
    assert found.confirmed
    assert np.rad2deg(found.value_rad) == pytest.approx(10.0, abs=0.1)


def test_a_hand_that_hardly_moves_raises_a_suspicion_that_only_a_probe_confirms() -> None:
    drift = NeutralDrift(1, 1e-3)
    assert judged(drift, 0.1, 30.0) is None
    suspicion = judged(drift, 0.1, 42.0, swing_deg=0.1)
    assert suspicion is not None
    assert not suspicion.confirmed
    assert judged(drift, 0.2, 30.0) is None, "it was tone"
    assert judged(drift, 0.2, 42.0, swing_deg=0.1) is not None
    confirmed = judged(drift, 0.2, 42.0)
    assert confirmed is not None
    assert confirmed.confirmed
    assert drift.judge() is None, "nothing noted, nothing known"
