"""Braking before power is cut: after a stop, at the end of a run, and where an error breaks a run off."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

from robot_iface.safety import brake_and_close
from robot_iface.types import SafetyState


def test_a_stop_brakes_first_and_cuts_power_only_when_all_is_still(rigid: Any) -> None:
    rig = rigid.stretch()
    rig.button.down = True
    rig.cycle()
    rig.button.down = False
    assert rig.hand.mode == "brake"
    assert rigid.peak_speed_deg_s(rig, 5000) > 5.0
    assert rig.outcomes[-1].powered is False
    cut = next(
        i
        for i, outcome in enumerate(rig.outcomes)
        if outcome.safety_state is SafetyState.CAT1 and not outcome.powered
    )
    assert np.rad2deg(np.abs([state.dq_rad_s for state in rig.states[cut - 98 : cut + 1]]).max()) < 5.0
    assert rig.hand.log[-2:] == ["brake", "power off"]


def test_a_trembling_hand_stays_braked_until_it_is_really_still(rigid: Any) -> None:
    """A 5 Hz clonus is slow twice in every beat; those moments must not add up to rest."""
    rig = rigid.Rig(
        ramp_s=0.05,
        stiffness=0.0,
        effort=lambda t_s: 0.03 * np.sin(10 * np.pi * t_s) * (0.2 < t_s < 3.0),
    )
    rig.go_active()
    rig.run(100)
    rig.button.down = True
    rig.run(2500)
    assert rig.hand.mode == "brake"
    rig.run(700)
    assert rig.hand.mode == "off"


def test_each_brake_has_all_of_its_time(rigid: Any) -> None:
    """A hand that trembled for 4.5 s after one run is braked for 5 s anew when the next one is stopped."""
    rig = rigid.Rig(ramp_s=0.05, stiffness=0.0, effort=lambda t_s: 0.03 * np.sin(10 * np.pi * t_s))
    rig.go_active()
    rig.run(100)
    rig.supervisor.finish()
    rig.run(4500)
    assert rig.hand.mode == "brake"
    rig.supervisor.enable_edge()
    rig.run(100)
    rig.button.down = True
    rig.run(4900)
    assert rig.hand.mode == "brake"
    rig.run(200)
    assert rig.hand.mode == "off"


def stopped_in_a_spasm(rigid: Any, lasts_s: float) -> Any:
    """A spasm of 0.3 Nm comes at 0.3 s, stop is pressed 0.2 s later, while the spasm holds the hand still."""
    rig = rigid.Rig(
        ramp_s=0.05,
        effort=lambda t_s: 0.3 * (0.3 < t_s < 0.3 + lasts_s),
        **(rigid.OPEN_SPASTIC | {"q_rad": 0.6}),
    )
    rig.supervisor.start()
    rig.run(3)
    rig.supervisor.enable_edge()
    rig.run(500 - len(rig.states))
    rig.button.down = True
    return rig


@pytest.mark.parametrize("lasts_s", [2.0, 3.0])
def test_the_end_of_a_spasm_that_held_the_hand_still_meets_a_brake(rigid: Any, lasts_s: float) -> None:
    rig = stopped_in_a_spasm(rigid, lasts_s)
    rig.run(round((0.3 + lasts_s) / rigid.PERIOD_S) - len(rig.states))
    assert rig.hand.mode == "brake", "the spasm still holds it, power must wait"
    assert np.abs(rig.states[-1].dq_rad_s).max() < np.deg2rad(2.0)
    free, snap = rigid.RigidHand(**(rigid.OPEN_SPASTIC | {"q_rad": rig.hand.q})), []
    for _ in range(200):
        free.step()
        snap.append(np.rad2deg(np.abs(free.dq).max()))
    assert rigid.peak_speed_deg_s(rig, 1000) < 0.3 * max(snap), "without power it would recoil freely"
    rig.run(4500)
    assert rig.hand.mode == "off"


@pytest.mark.parametrize("clonus", [False, True])
def test_no_brake_lasts_longer_than_five_seconds(rigid: Any, clonus: bool) -> None:
    """A spasm or tremor without end: the stop of category 1 ends without power all the same."""
    rig = rigid.Rig(
        ramp_s=0.05,
        stiffness=0.2,
        effort=lambda t_s: 0.1 * np.sin(10 * np.pi * t_s) if clonus else 0.5 * (t_s > 0.3),
    )
    rig.go_active()
    rig.run(290)
    rig.button.down = True
    rig.run(4990)
    assert rig.hand.mode == ("brake" if clonus else "off")
    rig.run(20)
    assert rig.hand.mode == "off"


def test_braking_keeps_the_snap_of_a_held_open_hand_far_below_power_off(rigid: Any) -> None:
    braked, cut = rigid.stretch(), rigid.stretch()
    braked.button.down = True
    cut.watch = dataclasses.replace(cut.watch, overruns_in_row=4)
    slow, fast = rigid.peak_speed_deg_s(braked, 600), rigid.peak_speed_deg_s(cut, 600)
    assert slow < 0.3 * fast


def test_finish_brakes_and_then_cuts_power_without_an_event(rigid: Any) -> None:
    rig = rigid.stretch()
    rig.supervisor.finish()
    assert rig.cycle().powered
    assert rig.hand.mode == "brake"
    assert rigid.peak_speed_deg_s(rig, 5000) < 170.0
    assert (rig.supervisor.state, rig.outcomes[-1].powered, rig.causes()) == (SafetyState.READY, False, [])
    rig.supervisor.close()
    assert rig.hand.log[-1] == "close"
    assert rig.supervisor.state is SafetyState.OFF


def leave(rig: Any, tick: Any = None, reading: Any = None) -> None:
    """Leave the loop as after an error: nobody calls ``write`` any more."""

    last = len(rig.states) + 5002

    def next_tick() -> int:
        assert len(rig.states) < last, "it brakes without end"
        rig.hand.step()
        rig.states.append(rig.hand.read())
        return int(rig.hand.tick * 1_000_000)

    if reading is not None:
        rig.hand.corrupt = reading
    brake_and_close(rig.supervisor, tick or next_tick)


def test_a_run_that_is_broken_off_brakes_before_it_closes(rigid: Any) -> None:
    """A hand held open by the robot: the same error used to snap it."""
    rig, abrupt = rigid.stretch(), rigid.stretch()
    left = len(rig.states)
    leave(rig)
    assert [word for word in rig.hand.log if word != "enable"] == [
        *("open", "brake", "power off"),
        *("power off", "close"),
    ]
    assert (rig.supervisor.state, rig.supervisor.powered) == (SafetyState.OFF, False)
    assert np.abs(rig.hand.dq).max() < np.deg2rad(5.0)
    abrupt.supervisor.close()
    snap = []
    for _ in range(600):
        abrupt.hand.step()
        snap.append(np.rad2deg(np.abs(abrupt.hand.dq).max()))
    braked = np.rad2deg(np.abs([state.dq_rad_s for state in rig.states[left:]]).max())
    assert braked < 0.3 * max(snap)


def test_a_run_that_is_broken_off_at_rest_is_stopped_too(rigid: Any) -> None:
    """Nothing but the leaving itself asks for the brake here."""
    rig = rigid.Rig(ramp_s=0.05)
    rig.go_active()
    leave(rig)
    assert rig.hand.log[-4:] == ["brake", "power off", "power off", "close"]


def test_leaving_an_unpowered_device_waits_for_nothing(rigid: Any) -> None:
    rig = rigid.Rig()
    rig.supervisor.start()
    rig.run(3)
    leave(rig, tick=lambda: pytest.fail("waited"))
    assert rig.hand.log == ["open", "power off", "close"]


def test_a_clock_that_fails_while_leaving_cuts_power_and_closes(rigid: Any) -> None:
    rig = rigid.stretch()

    def broken() -> int:
        raise RuntimeError("clock")

    with pytest.raises(RuntimeError, match="clock"):
        leave(rig, tick=broken)
    assert rig.hand.log[-2:] == ["power off", "close"]


def test_sensors_that_cannot_be_trusted_while_leaving_cut_power_at_once(rigid: Any) -> None:
    rig = rigid.stretch()
    left = len(rig.states)
    leave(rig, reading=lambda state: dataclasses.replace(state, q_rad=np.full(3, np.nan)))
    assert len(rig.states) - left <= 2
    assert rig.hand.log[-1] == "close"
