"""The state machine: ramp, latching, reset, hold and lowering."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

from robot_iface.errors import Refused
from robot_iface.safety import Supervisor
from robot_iface.types import SafetyState


def test_ramp_in_lasts_as_prescribed_and_torque_grows_with_it(rigid: Any) -> None:
    rig = rigid.Rig(ramp_s=2.0, **rigid.OPEN_SPASTIC)
    rig.goal = np.full(3, 0.1)
    rig.supervisor.start()
    rig.run(3)
    rig.supervisor.enable_edge()
    assert rig.ticks_until(SafetyState.ACTIVE, 2002) == pytest.approx(2000, abs=2)
    caps = 0.95 * rig.limits.tau_interaction_nm
    ramps = np.array([outcome.ramp for outcome in rig.outcomes[3:]])
    torques = np.array([np.abs(outcome.applied_tau_nm) for outcome in rig.outcomes[3:]])
    assert np.all(torques[1:] <= ramps[:-1, None] * caps + 1e-12)
    assert np.all(np.diff(ramps) >= 0)


def test_nothing_reaches_the_device_before_the_enable(rigid: Any) -> None:
    rig = rigid.Rig()
    rig.supervisor.start()
    rig.goal = np.full(3, 1.2)
    outcome = rig.run(100)
    assert (outcome.safety_state, outcome.powered) == (SafetyState.READY, False)
    assert np.all(outcome.applied_tau_nm == 0.0)
    assert rig.hand.log == ["open"]


FAULTS = {
    SafetyState.HOLD: {"enable_held": False},
    SafetyState.CAT1: {"heartbeat_age_ns": 10**9},
    SafetyState.CAT0: {"overruns_in_row": 4},
}
GOOD = {"enable_held": True, "heartbeat_age_ns": 0, "overruns_in_row": 0}


@pytest.mark.parametrize("state", FAULTS)
def test_states_are_latched_and_left_only_by_reset_and_a_new_enable(rigid: Any, state: SafetyState) -> None:
    rig = rigid.Rig()
    rig.go_active()
    rig.run(1, **FAULTS[state])
    assert rig.run(500, **GOOD).safety_state is state, "the cause is gone, the state stays"
    with pytest.raises(Refused, match="READY"):
        rig.supervisor.enable_edge()
    with pytest.raises(Refused, match="person"):
        rig.supervisor.reset(present=False)
    rig.supervisor.reset(present=True)
    assert rig.run(300).safety_state is SafetyState.READY
    assert rig.hand.mode in ("brake", "off"), "a reset must not start motion"
    rig.supervisor.enable_edge()
    assert rig.cycle().safety_state is SafetyState.RAMP_IN
    assert rig.supervisor.ramp < 0.01


def test_reset_is_refused_while_stop_is_pressed_or_the_hand_moves(rigid: Any) -> None:
    rig = rigid.Rig()
    rig.go_active()
    rig.button.down = True
    rig.cycle()
    with pytest.raises(Refused, match="stop is pressed"):
        rig.supervisor.reset(present=True)
    rig.button.down = False
    rig.hand.dq[:] = 1.0
    rig.cycle()
    with pytest.raises(Refused, match="degrees/s"):
        rig.supervisor.reset(present=True)


def test_states_only_get_worse(rigid: Any) -> None:
    rig = rigid.Rig()
    rig.go_active()
    for state in (SafetyState.HOLD, SafetyState.CAT1):
        assert rig.run(1, **GOOD | FAULTS[state]).safety_state is state
    assert rig.run(1, **GOOD | FAULTS[SafetyState.HOLD]).safety_state is SafetyState.CAT1
    rig.hand.corrupt = lambda reading: dataclasses.replace(reading, q_rad=np.full(3, np.nan))
    assert rig.cycle().safety_state is SafetyState.CAT0
    assert rig.hand.mode == "off"
    assert len(rig.events()) == 3


def test_the_worst_of_several_faults_wins(rigid: Any) -> None:
    rig = rigid.Rig()
    rig.go_active()
    rig.button.down = True
    worst = {"overruns_in_row": 4, "enable_held": False}
    assert rig.run(1, **worst).safety_state is SafetyState.CAT0
    assert rig.causes() == ["overruns"]


def test_enabling_is_refused_outside_the_range_or_with_the_stop_pressed(rigid: Any) -> None:
    rig = rigid.Rig(q_rad=1.7, stiffness=0.0)
    rig.supervisor.start()
    with pytest.raises(Refused, match="unread"):
        rig.supervisor.enable_edge()
    rig.cycle()
    with pytest.raises(Refused, match=r"index_mcp_flexion is at 97\.4 degrees"):
        rig.supervisor.enable_edge()
    rig.hand.q[:] = 0.5
    rig.button.down = True
    rig.supervisor.read(rig.hand.tick * rigid.PERIOD_NS)
    with pytest.raises(Refused, match="stop is pressed"):
        rig.supervisor.enable_edge()


def test_starting_twice_or_with_foreign_limits_is_refused(rigid: Any) -> None:
    rig = rigid.Rig()
    rig.supervisor.start()
    with pytest.raises(Refused, match="READY"):
        rig.supervisor.start()
    short = dataclasses.replace(rig.limits, q_min_rad=rig.limits.q_min_rad[:2])
    with pytest.raises(Refused, match="for 2 joints"):
        rigid.Rig(limits=short)


def test_hold_keeps_the_posture_and_its_torque(rigid: Any) -> None:
    rig = rigid.stretch()
    before, torque = rig.states[-1].q_rad, rig.outcomes[-1].applied_tau_nm
    outcome = rig.run(1, enable_held=False)
    rig.goal = np.full(3, 1.2)
    assert np.abs(outcome.applied_tau_nm - torque).max() < 0.02
    rig.run(500)
    assert np.abs(rig.states[-1].q_rad - before).max() < np.deg2rad(1.0)


def test_hold_stands_still_even_from_motion(rigid: Any) -> None:
    rig = rigid.Rig(ramp_s=0.05)
    rig.go_active()
    rig.speed = np.full(3, 0.3)
    rig.run(300)
    outcome = rig.run(1, enable_held=False)
    assert np.all(outcome.applied.dq_rad_s == 0.0)
    rig.run(300)
    assert np.abs(rig.states[-1].dq_rad_s).max() < 1e-3


def test_loads_are_counted_anew_after_every_enable(rigid: Any) -> None:
    rig = rigid.Rig(ramp_s=0.05)
    rig.hand.corrupt = lambda state: dataclasses.replace(state, tau_interaction_nm=np.full(3, 0.09))
    rig.go_active()
    for _ in range(3):
        rig.run(2500)
        rig.supervisor.finish()
        rig.run(200)
        rig.supervisor.enable_edge()
    assert rig.causes() == []


def test_pain_lowers_at_once(rigid: Any) -> None:
    rig = rigid.stretch()
    rig.run(1, pain=True)
    rig.run(2500, pain=False)
    assert rig.causes() == ["pain"]
    assert rig.outcomes[-1].load_share < 0.15


def test_a_caller_can_ask_for_a_stop(rigid: Any) -> None:
    rig = rigid.Rig()
    rig.go_active()
    rig.supervisor.request_stop("link-closed")
    assert rig.cycle().safety_state is SafetyState.CAT1
    assert rig.causes() == ["link-closed"]


def test_cutting_in_the_ready_state_needs_a_reset_too(rigid: Any) -> None:
    rig = rigid.Rig()
    rig.supervisor.start()
    rig.run(5)
    rig.button.down = True
    assert rig.cycle().safety_state is SafetyState.CAT1
    rig.button.down = False
    with pytest.raises(Refused):
        rig.supervisor.enable_edge()


def test_write_before_read_is_refused(rigid: Any) -> None:
    rig = rigid.Rig()
    rig.supervisor.start()
    with pytest.raises(Refused, match="call read before write"):
        rig.supervisor.write(None, rig.watch)


@pytest.mark.parametrize("held_by", ["active", "hold"])
def test_a_stretch_that_is_held_for_three_seconds_is_lowered_slowly(rigid: Any, held_by: str) -> None:
    rig = rigid.stretch()
    start = rig.states[-1]
    assert rig.outcomes[-1].load_share > 0.5
    if held_by == "hold":
        rig.run(1, enable_held=False)
    rig.run(2000)
    assert rig.causes() == (["enable-released"] if held_by == "hold" else [])
    rig.run(1500)
    assert rig.causes()[-1] == "held-stretch"
    rig.run(3000)
    assert rig.supervisor.state is SafetyState.HOLD
    assert rig.outcomes[-1].load_share < 0.15
    assert np.all(rig.states[-1].q_rad > start.q_rad + np.deg2rad(5.0)), "it gave way towards flexion"
    speeds = np.rad2deg(np.abs([state.dq_rad_s for state in rig.states[-5000:]]).max())
    assert speeds <= 21.0


def test_a_stretch_by_feed_forward_alone_is_lowered_too(rigid: Any) -> None:
    """Without stiffness no posture holds the hand open: the torque itself has to fade."""
    rig = rigid.Rig(ramp_s=0.05, **rigid.OPEN_SPASTIC)
    rig.go_active()
    torque = np.zeros(3)

    def push(request: Any) -> Any:
        torque[1] = max(torque[1] - 0.001, -0.12)
        return dataclasses.replace(
            request, stiffness_nm_rad=np.zeros(3), damping_nms_rad=np.full(3, 0.05), tau_ff_nm=torque.copy()
        )

    rig.change = push
    rig.run(1500)
    assert rig.outcomes[-1].load_share > 0.7
    rig.run(1, pain=True)
    rig.run(3000)
    assert rig.causes() == ["pain"]
    assert rig.outcomes[-1].load_share < 0.15


def test_a_stretch_is_not_held_against_a_moving_path(rigid: Any) -> None:
    """While the path moves, the time-out of the repetition bounds a blocked stretch, not this rule."""
    rig = rigid.stretch()
    rig.speed = np.full(3, np.deg2rad(-2.0))
    rig.goal = rig.goal + 1.0
    rig.multiple = 1e-6
    rig.run(4000)
    assert "held-stretch" not in rig.causes()


@pytest.mark.parametrize(("path_deg_s", "held"), [(0.9, True), (1.1, False)])
def test_a_load_is_a_held_stretch_only_while_the_path_rests(
    rigid: Any, path_deg_s: float, held: bool
) -> None:
    rig = rigid.Rig(ramp_s=0.05, stiffness=0.0)
    rig.go_active()
    rig.hand.corrupt = lambda state: dataclasses.replace(
        state, tau_interaction_nm=0.6 * rig.limits.tau_interaction_nm
    )
    rig.glide(np.deg2rad(path_deg_s), 3.1)
    assert rig.causes() == (["held-stretch"] if held else [])


@pytest.mark.parametrize(("speed_deg_s", "held"), [(4.9, True), (5.1, False)])
@pytest.mark.parametrize("share", [0.51, 0.49])
def test_a_stretch_is_held_only_while_the_hand_itself_rests(
    rigid: Any, share: float, speed_deg_s: float, held: bool
) -> None:
    rig = rigid.Rig(ramp_s=0.05)
    rig.go_active()
    rig.hand.corrupt = lambda state: dataclasses.replace(
        state,
        tau_interaction_nm=-share * rig.limits.tau_interaction_nm,
        dq_rad_s=np.full(3, np.deg2rad(speed_deg_s)),
    )
    rig.supervisor._previous = None
    rig.run(2990)
    assert rig.causes() == []
    rig.run(20)
    assert rig.causes() == (["held-stretch"] if held and share > 0.5 else [])


def test_torque_comes_back_over_a_second_unless_something_else_is_said(rigid: Any) -> None:
    rig = rigid.Rig()
    rig.supervisor = Supervisor(rig.hand, rig.limits, rig.button, rigid.PERIOD_NS)
    rig.go_active()
    shares = [outcome.ramp for outcome in rig.outcomes if outcome.safety_state is SafetyState.RAMP_IN]
    assert len(shares) == pytest.approx(1000, abs=2)
    assert np.all(np.diff(shares) > 0.0)
