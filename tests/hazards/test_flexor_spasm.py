"""Hazard 3: a flexor spasm meets the robot. The cure is tested, not only the trigger."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from robot_iface.control import thesis_gains
from robot_iface.types import CommandMode, DeviceCommand, SafetyState

SPASM_AT_S = 0.6
HAND = {"q_rad": 0.8, "rest_rad": 0.8, "stiffness": 0.2}
OPENING, CLOSING = np.deg2rad(-15.0), np.deg2rad(30.0)


def spasm(size_nm: float, duration_s: float, clonus_hz: float = 0.0) -> Callable[[float], float]:
    """Flexor torque in time; with a clonus it comes and goes at that frequency."""

    def effort(t_s: float) -> float:
        since = t_s - SPASM_AT_S
        if not 0.0 <= since < duration_s:
            return 0.0
        beats = clonus_hz == 0.0 or np.sin(2 * np.pi * clonus_hz * since) > 0.0
        return size_nm if beats else 0.0

    return effort


def supervised(rigid: Any, effort: Callable[[float], float], speed_rad_s: float, seconds: float) -> Any:
    rig = rigid.Rig(ramp_s=0.05, effort=effort, **HAND)
    rig.go_active()
    rig.glide(speed_rad_s, SPASM_AT_S - rig.hand.tick * rigid.PERIOD_S)
    rig.spasm_tick = len(rig.states)
    rig.speed = np.zeros(3) + speed_rad_s
    rig.run(round(seconds / rigid.PERIOD_S))
    return rig


def unsupervised_peak_rad_s(
    rigid: Any, effort: Callable[[float], float], speed_rad_s: float, seconds: float
) -> float:
    """The same law, bounded by the motors alone."""
    hand = rigid.RigidHand(effort=effort, **HAND)
    gains = thesis_gains(rigid.NAMES).scaled(3.0)
    goal, speeds = hand.q.copy(), []
    hand.enable()
    for tick in range(round((SPASM_AT_S + seconds) / rigid.PERIOD_S)):
        speed = speed_rad_s if tick >= 54 else 0.0
        goal = goal + speed * rigid.PERIOD_S
        torque = gains.stiffness_nm_rad * (goal - hand.q) + gains.damping_nms_rad * (speed - hand.dq)
        zeros = np.zeros(3)
        torque = np.clip(torque, -0.6, 0.6)
        hand.write(DeviceCommand(CommandMode.TORQUE, zeros, zeros, torque, zeros, zeros, 0))
        hand.step()
        speeds.append(np.abs(hand.dq).max())
    return float(np.max(speeds))


@pytest.mark.parametrize("phase", [OPENING, CLOSING], ids=["opening", "closing"])
@pytest.mark.parametrize("duration_s", [0.1, 0.5, 1.0])
@pytest.mark.parametrize("size_nm", [0.1, 0.3, 0.5, 0.9])
def test_the_supervisor_never_makes_a_spasm_worse(
    rigid: Any, size_nm: float, duration_s: float, phase: float
) -> None:
    """Peak speed under power is no higher than with the law and the motors alone."""
    effort = spasm(size_nm, duration_s)
    rig = supervised(rigid, effort, phase, duration_s)
    powered = [state for state, outcome in zip(rig.states, rig.outcomes, strict=True) if outcome.powered]
    peak = float(np.abs([state.dq_rad_s for state in powered[rig.spasm_tick :]]).max())
    assert peak <= 1.02 * unsupervised_peak_rad_s(rigid, effort, phase, duration_s)
    if size_nm > 0.25:
        assert rig.supervisor.state in (SafetyState.COMPLIANT, SafetyState.CAT1)


@pytest.mark.parametrize("frequency_hz", [5.0, 6.0, 7.0])
def test_clonus_is_followed_damped(rigid: Any, frequency_hz: float) -> None:
    effort = spasm(0.3, 2.0, frequency_hz)
    rig = supervised(rigid, effort, OPENING, 2.0)
    peak = float(np.abs([state.dq_rad_s for state in rig.states[rig.spasm_tick :]]).max())
    assert peak < 0.6 * unsupervised_peak_rad_s(rigid, effort, OPENING, 2.0)


@pytest.mark.parametrize("phase", [OPENING, CLOSING], ids=["opening", "closing"])
@pytest.mark.parametrize("size_nm", [0.3, 0.5, 0.9])
def test_after_the_trip_the_robot_never_drives_the_hand(rigid: Any, size_nm: float, phase: float) -> None:
    """From COMPLIANT on every torque only brakes: no extension is forced on a hand that closes."""
    rig = supervised(rigid, spasm(size_nm, 0.5), phase, 0.8)
    tripped = [i for i, outcome in enumerate(rig.outcomes) if outcome.safety_state >= SafetyState.COMPLIANT]
    assert tripped[0] - rig.spasm_tick < 400
    power = [rig.outcomes[i].applied_tau_nm * rig.states[i].dq_rad_s for i in tripped]
    assert float(np.max(power)) <= 0.0


@pytest.mark.parametrize("duration_s", [0.5, 1.5, 3.0])
@pytest.mark.parametrize("size_nm", [0.3, 0.5, 0.9])
def test_the_end_of_a_spasm_meets_the_brake_of_a_stop(rigid: Any, size_nm: float, duration_s: float) -> None:
    """Stop is pressed in the spasm; the spasm then holds the hand still, and that is not yet rest."""
    rig = rigid.Rig(ramp_s=0.05, effort=spasm(size_nm, duration_s), **HAND)
    rig.go_active()
    rig.run(round((SPASM_AT_S + 0.1) / rigid.PERIOD_S) - rig.hand.tick)
    rig.button.down = True
    rig.run(round((SPASM_AT_S + duration_s) / rigid.PERIOD_S) - rig.hand.tick)
    assert rig.supervisor.state is SafetyState.CAT1
    assert rig.hand.mode == "brake"
    rig.run(6000)
    assert rig.hand.mode == "off", "and the stop still ends without power"
