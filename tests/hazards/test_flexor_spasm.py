"""Hazard 3: a flexor spasm meets the robot. The cure is tested, not only the trigger."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from robot_iface.control import Goal
from robot_iface.motion import PathState, Setpoint
from robot_iface.types import DeviceCommand, SafetyState

SPASM_AT_S = 0.6
HAND = {"q_rad": 0.8, "rest_rad": 0.8, "stiffness": 0.2}
ROUNDING = 1e-6
OPENING, CLOSING = np.deg2rad(-15.0), np.deg2rad(30.0)


def spasm(
    size_nm: float, duration_s: float, clonus_hz: float = 0.0, at_s: float = SPASM_AT_S
) -> Callable[[float], float]:
    """Flexor torque in time; with a clonus it comes and goes at that frequency."""

    def effort(t_s: float) -> float:
        since = t_s - at_s
        if not 0.0 <= since < duration_s:
            return 0.0
        beats = clonus_hz == 0.0 or np.sin(2 * np.pi * clonus_hz * since) > 0.0
        return size_nm if beats else 0.0

    return effort


def supervised(
    rigid: Any,
    effort: Callable[[float], float],
    speed_rad_s: float,
    seconds: float,
    at_s: float = SPASM_AT_S,
    **hand: float,
) -> Any:
    rig = rigid.Rig(ramp_s=0.05, effort=effort, **(HAND | hand))
    rig.go_active()
    rig.glide(speed_rad_s, at_s - rig.hand.tick * rigid.PERIOD_S)
    rig.spasm_tick = len(rig.states)
    rig.speed = np.zeros(3) + speed_rad_s
    rig.run(round(seconds / rigid.PERIOD_S))
    return rig


def peaks(rig: Any) -> tuple[float, float]:
    """Peak speed and peak interaction torque under power from the spasm on."""
    pairs = zip(rig.states[rig.spasm_tick :], rig.outcomes[rig.spasm_tick :], strict=True)
    after = [state for state, outcome in pairs if outcome.powered]
    speed = np.abs([state.dq_rad_s for state in after]).max()
    return float(speed), float(np.abs([state.tau_interaction_nm for state in after]).max())


@functools.cache
def unsupervised(
    rigid: Any,
    size_nm: float,
    duration_s: float,
    clonus_hz: float,
    speed_rad_s: float,
    at_s: float = SPASM_AT_S,
    stiffness: float = HAND["stiffness"],
) -> tuple[float, float]:
    """Peak speed and peak interaction torque with the same law on the same path, bounded by the motors alone.

    The same law, and not motors without torque: those do not load a hand at all, so that no brake, and no
    robot, would be better than none.
    """
    rig = rigid.Rig(ramp_s=0.05, **(HAND | {"stiffness": stiffness}))
    rig.go_active()  # the path begins when the robot follows, as with a supervisor
    first = rig.hand.tick
    hand = rigid.RigidHand(
        effort=spasm(size_nm, duration_s, clonus_hz, at_s), **(HAND | {"stiffness": stiffness})
    )
    hand.enable()
    goal, speeds, loads = hand.q.copy(), [], []
    for tick in range(round((at_s + duration_s) / rigid.PERIOD_S)):
        speed = np.full(3, speed_rad_s if tick >= first else 0.0)
        goal = goal + speed * rigid.PERIOD_S
        setpoint = Setpoint(goal, speed, np.zeros(3))
        wanted = Goal(setpoint, np.full(3, 3.0), np.zeros(3), PathState(0.0, 0.0, 0.0, False))
        hand.write(within_motors(hand, rig.law.command(hand.read(), wanted, 1.0, tick)))
        hand.step()
        speeds.append(np.abs(hand.dq).max())
        loads.append(np.abs(hand.tau - rigid.ROTOR * hand.ddq).max())
    return float(np.max(speeds)), float(np.max(loads))


def within_motors(hand: Any, request: DeviceCommand) -> DeviceCommand:
    """The request as motors of 0.6 Nm give it."""
    spring = request.stiffness_nm_rad * (request.q_rad - hand.q)
    torque = spring + request.damping_nms_rad * (request.dq_rad_s - hand.dq) + request.tau_ff_nm
    given = np.clip(torque, -0.6, 0.6)
    return dataclasses.replace(request, tau_ff_nm=request.tau_ff_nm + given - torque)


MAP = [
    *((size, duration, 0.0) for size in (0.1, 0.2, 0.3, 0.5, 0.7, 0.9) for duration in (0.1, 0.5, 3.0)),
    *((size, 2.0, beat) for size in (0.1, 0.3, 0.9) for beat in (5.0, 6.0, 7.0)),
]
"""Amplitude Nm, duration s, frequency of a clonus Hz."""


@pytest.mark.parametrize("phase", [OPENING, CLOSING], ids=["opening", "closing"])
@pytest.mark.parametrize(("size_nm", "duration_s", "clonus_hz"), MAP)
def test_the_supervisor_never_makes_a_spasm_worse(
    rigid: Any, size_nm: float, duration_s: float, clonus_hz: float, phase: float
) -> None:
    """Neither peak of a spasm is above that of the law alone; a weak clonus may be 3 % faster.

    Between its beats a load has been gone back on, after which the robot pushes with half its torque.
    """
    rig = supervised(rigid, spasm(size_nm, duration_s, clonus_hz), phase, duration_s)
    speed, torque = peaks(rig)
    alone_speed, alone_torque = unsupervised(rigid, size_nm, duration_s, clonus_hz, phase)
    assert speed <= (1.0 + ROUNDING if clonus_hz == 0.0 else 1.03) * alone_speed
    assert torque <= (1.0 + ROUNDING) * alone_torque
    if size_nm > 0.25:
        assert rig.supervisor.state in (SafetyState.COMPLIANT, SafetyState.CAT1)


@pytest.mark.parametrize("seed", range(24))
def test_nor_one_that_nothing_was_tuned_on(rigid: Any, seed: int) -> None:
    """Any amplitude, duration, phase, speed and beat, on hands from limp to stiff."""
    rng = np.random.default_rng([23, seed])
    size_nm, duration_s, at_s = rng.uniform(0.08, 0.95), rng.uniform(0.1, 0.6), rng.uniform(0.3, 0.65)
    clonus_hz = float(rng.choice([0.0, 0.0, 5.0, 6.3, 7.0]))
    stiffness = float(rng.choice([0.03, 0.1, 0.2, 0.3, 0.4, 0.6]))
    fastest = 0.08 / (stiffness * at_s)  # the motion alone is no load yet when the spasm comes
    phase = float(np.clip(np.deg2rad(rng.choice([-30.0, -15.0, -5.0, 10.0, 30.0, 60.0])), -fastest, fastest))
    effort = spasm(size_nm, duration_s, clonus_hz, at_s)
    rig = supervised(rigid, effort, phase, duration_s, at_s, stiffness=stiffness)
    speed, torque = peaks(rig)
    alone = unsupervised(rigid, size_nm, duration_s, clonus_hz, phase, at_s, stiffness)
    assert speed <= 1.03 * alone[0]
    assert torque <= 1.05 * alone[1]


@pytest.mark.parametrize("phase", [OPENING, CLOSING], ids=["opening", "closing"])
@pytest.mark.parametrize(("size_nm", "duration_s", "clonus_hz"), MAP)
def test_no_spring_opens_a_hand_that_closes_once_the_supervisor_acts(
    rigid: Any, size_nm: float, duration_s: float, clonus_hz: float, phase: float
) -> None:
    """From reversal or yielding on, what opposes a closing hand is damping and nothing else."""
    rig = supervised(rigid, spasm(size_nm, duration_s, clonus_hz), phase, min(duration_s, 1.0))
    for state, outcome in zip(rig.states, rig.outcomes, strict=True):
        if not outcome.reversing and outcome.safety_state < SafetyState.COMPLIANT:
            continue
        command = outcome.applied
        spring = command.stiffness_nm_rad * (command.q_rad - state.q_rad) + command.tau_ff_nm
        closes = state.dq_rad_s > np.deg2rad(5.0)
        clamped = np.abs(outcome.applied_tau_nm) < np.abs(outcome.requested_tau_nm)
        assert np.all(spring[closes & ~clamped] >= -1e-9)


def test_a_short_spasm_against_the_opening_is_gone_back_on_and_the_run_goes_on(rigid: Any) -> None:
    rig = supervised(rigid, spasm(0.1, 0.1), OPENING, 2.0)
    assert rig.causes() == ["reversal"]
    assert rig.supervisor.state is SafetyState.ACTIVE
    assert sum(outcome.reversed for outcome in rig.outcomes) == 1


def test_a_spasm_that_helps_the_closing_is_never_reversed(rigid: Any) -> None:
    for size_nm in (0.2, 0.3, 0.9):
        rig = supervised(rigid, spasm(size_nm, 1.0), CLOSING, 1.0)
        assert not any(outcome.reversing for outcome in rig.outcomes)


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
