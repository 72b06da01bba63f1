"""Going back on a load that opposes the motion: when, how far, how fast, and when it yields instead."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

from robot_iface.types import SafetyState

from .reversing import CLOSING, OPENING, gliding, load, unload, until_reversal


@pytest.mark.parametrize("speed", [OPENING, CLOSING])
@pytest.mark.parametrize("joint", range(3))
def test_a_load_against_the_motion_is_gone_back_on_and_the_hand_is_given_back(
    rigid: Any, joint: int, speed: float
) -> None:
    rig = gliding(rigid, speed, stiffness=0.0)
    load(rig, np.sign(speed) * 1.2, joint)
    assert until_reversal(rig) == 10
    event = rig.events()[-1]
    limit = rig.limits.tau_interaction_nm[joint]
    assert (event.cause, event.state, event.joint) == ("reversal", SafetyState.ACTIVE, rigid.NAMES[joint])
    assert (event.value, event.bound) == pytest.approx((1.2 * limit, limit))
    start = rig.states[-1].q_rad
    unload(rig)
    ticks = 1
    while not rig.cycle().reversed:
        ticks += 1
        assert ticks < 700
    assert ticks == pytest.approx(10.0 / 15.0 * 1000, abs=1)
    back = np.rad2deg(rig.states[-1].q_rad - start) * -np.sign(speed)
    assert np.all(back > 6.0)
    assert np.all(back < 10.5)
    speeds = np.rad2deg(np.abs([state.dq_rad_s for state in rig.states[-ticks + 150 :]]))
    assert speeds.max() < 15.1
    assert rig.causes() == ["reversal"]
    assert not rig.outcomes[-1].reversing


def test_only_the_tick_after_the_last_gives_the_hand_back(rigid: Any) -> None:
    rig = gliding(rigid)
    load(rig, -1.2)
    until_reversal(rig)
    unload(rig)
    rig.run(1000)
    reversing = [outcome.reversing for outcome in rig.outcomes]
    given = [outcome.reversed for outcome in rig.outcomes]
    assert sum(given) == 1
    assert not reversing[given.index(True)]
    assert reversing[given.index(True) - 1]
    assert not any(reversing[given.index(True) :])


def test_requests_do_not_pass_while_it_goes_back_and_are_clamped_to_half_at_first(rigid: Any) -> None:
    rig = gliding(rigid)
    load(rig, -1.2)
    until_reversal(rig)
    unload(rig)
    rig.change = lambda request: dataclasses.replace(request, tau_ff_nm=np.full(3, 9.0))
    while not rig.cycle().reversed:
        assert rig.outcomes[-1].reversing
        assert np.all(rig.outcomes[-1].applied.tau_ff_nm == 0.0)
    assert rig.causes() == ["reversal"], "the mad requests were not even looked at"
    rig.change = lambda request: dataclasses.replace(request, tau_ff_nm=np.full(3, 0.5))
    rig.hand.effort = lambda t_s: -rig.hand.command.tau_ff_nm
    caps = 0.95 * rig.limits.tau_interaction_nm
    shares = np.array([rig.cycle().applied_tau_nm / caps for _ in range(30)])
    assert rig.causes() == ["reversal"]
    expected = 0.5 + np.arange(30) * 1e-3 / 0.05
    assert np.allclose(shares, np.minimum(expected, 1.0)[:, None], atol=0.021)


def test_a_load_that_does_not_fall_in_200_ms_is_yielded_to(rigid: Any) -> None:
    rig = gliding(rigid)
    load(rig, -1.2)
    until_reversal(rig)
    load(rig, -0.81)
    assert rig.ticks_until(SafetyState.COMPLIANT, 201) == 200
    assert rig.causes() == ["reversal", "load"]
    assert np.all(rig.outcomes[-1].applied.stiffness_nm_rad == 0.0)


def test_a_load_that_falls_just_in_time_is_enough(rigid: Any) -> None:
    rig = gliding(rigid)
    load(rig, -1.2)
    until_reversal(rig)
    rig.run(189)
    load(rig, -0.79)
    rig.run(9)
    load(rig, -0.81)
    assert rig.ticks_until(SafetyState.COMPLIANT, 2) == 2, "9 ms below are no fall"
    rig = gliding(rigid)
    load(rig, -1.2)
    until_reversal(rig)
    rig.run(189)
    load(rig, -0.79)
    rig.run(10)
    load(rig, -0.81)
    rig.run(100)
    assert rig.causes() == ["reversal"]


def test_a_load_that_comes_back_after_falling_is_yielded_to(rigid: Any) -> None:
    rig = gliding(rigid)
    load(rig, -1.2)
    until_reversal(rig)
    unload(rig)
    rig.run(300)
    load(rig, -0.99)
    rig.run(100)
    load(rig, -1.01)
    assert rig.ticks_until(SafetyState.COMPLIANT, 1) == 1


def test_a_load_against_the_way_back_is_yielded_to(rigid: Any) -> None:
    """The patient resists closing, then a spasm resists the way back: nobody knows what is wanted."""
    rig = gliding(rigid, CLOSING)
    load(rig, 1.2)
    until_reversal(rig)
    unload(rig)
    rig.run(100)
    load(rig, -0.49)
    assert rig.run(20).reversing
    load(rig, -0.51)
    assert rig.ticks_until(SafetyState.COMPLIANT, 1) == 1
    assert rig.causes() == ["reversal", "load"]


@pytest.mark.parametrize("speed", [OPENING, CLOSING])
def test_a_patient_who_drives_with_the_motion_is_followed_never_reversed(rigid: Any, speed: float) -> None:
    rig = gliding(rigid, speed)
    load(rig, -np.sign(speed) * 1.2)
    assert rig.ticks_until(SafetyState.COMPLIANT, 10) == 10
    assert rig.causes() == ["load"]
    assert not any(outcome.reversing for outcome in rig.outcomes)


def test_a_load_at_rest_is_yielded_to(rigid: Any) -> None:
    rig = gliding(rigid, np.deg2rad(-0.9))
    load(rig, -1.2)
    assert rig.ticks_until(SafetyState.COMPLIANT, 10) == 10
    rig = gliding(rigid, np.deg2rad(-1.1))
    load(rig, -1.2)
    assert until_reversal(rig) == 10


def test_two_loads_of_which_one_drives_with_the_motion_are_yielded_to(rigid: Any) -> None:
    rig = gliding(rigid)
    rig.hand.corrupt = lambda state: dataclasses.replace(
        state, tau_interaction_nm=np.array([-1.2, 1.2, 0.0]) * rig.limits.tau_interaction_nm
    )
    assert rig.ticks_until(SafetyState.COMPLIANT, 10) == 10


def test_far_over_the_limit_nothing_is_waited_for(rigid: Any) -> None:
    rig = gliding(rigid)
    load(rig, -1.51)
    assert rig.ticks_until(SafetyState.COMPLIANT, 1) == 1
    rig = gliding(rigid)
    load(rig, -1.2)
    until_reversal(rig)
    load(rig, -1.51)
    assert rig.ticks_until(SafetyState.COMPLIANT, 1) == 1
    assert rig.causes() == ["reversal", "load-hard"]


def test_a_load_while_torque_still_rises_is_yielded_to(rigid: Any) -> None:
    rig = gliding(rigid)
    load(rig, -1.2)
    until_reversal(rig)
    unload(rig)
    while not rig.cycle().reversed:
        pass
    load(rig, -1.2)
    assert rig.ticks_until(SafetyState.COMPLIANT, 10) == 10


def test_pain_and_a_load_in_one_tick_are_no_reversal(rigid: Any) -> None:
    rig = gliding(rigid)
    load(rig, -1.2)
    rig.run(9)
    assert rig.run(1, pain=True).safety_state is SafetyState.COMPLIANT


@pytest.mark.parametrize(
    ("watch", "state"),
    [
        ({"pain": True}, SafetyState.HOLD),
        ({"enable_held": False}, SafetyState.HOLD),
        ({"heartbeat_age_ns": 10**9}, SafetyState.CAT1),
        ({"overruns_in_row": 4}, SafetyState.CAT0),
    ],
)
def test_everything_else_goes_on_being_watched(rigid: Any, watch: Any, state: SafetyState) -> None:
    rig = gliding(rigid)
    load(rig, -1.2)
    until_reversal(rig)
    rig.run(50)
    assert rig.run(1, **watch).safety_state is state
    assert not rig.outcomes[-1].reversing
    assert not any(outcome.reversed for outcome in rig.outcomes)


@pytest.mark.parametrize(
    ("watch", "state"),
    [
        ({"pain": True}, SafetyState.HOLD),
        ({"heartbeat_age_ns": 10**9}, SafetyState.CAT1),
        ({"overruns_in_row": 4}, SafetyState.CAT0),
    ],
)
def test_nothing_but_a_load_is_gone_back_on(rigid: Any, watch: Any, state: SafetyState) -> None:
    """The load has not lasted long enough to count when something else goes wrong: that alone decides."""
    rig = gliding(rigid)
    load(rig, -1.2)
    rig.run(5)
    assert not rig.causes()
    assert rig.run(1, **watch).safety_state is state
    assert not any(outcome.reversing for outcome in rig.outcomes)


def test_a_stop_and_a_finish_end_it(rigid: Any) -> None:
    for end in ("stop", "finish"):
        rig = gliding(rigid)
        load(rig, -1.2)
        until_reversal(rig)
        if end == "stop":
            rig.button.down = True
        else:
            rig.supervisor.finish()
        outcome = rig.cycle()
        assert rig.hand.mode == "brake"
        assert not outcome.reversing
