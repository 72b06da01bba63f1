"""Pause, speed, pain, stop, reset: what a person orders happens, and nothing resumes by itself."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from robot_iface.errors import Refused
from robot_iface.runtime import Pain, Pause, Reset, Resume, SetSpeed
from robot_iface.sim import DRIVEN, Fault
from robot_iface.types import Plan, SafetyState

MakePlan = Callable[..., Plan]
MOVING_S = 4.0
"""A time in the middle of the movement of every plan here."""


def at_rest_from(run: Any) -> float:
    """Time from which the path coordinate does not move any more."""
    speed = run.column("path_speed")
    return float(run.column("t_ns")[np.flatnonzero(speed)[-1]]) * 1e-9


def test_stop_stops_the_path_at_once_brakes_and_then_cuts_power(make_plan: MakePlan, course: Any) -> None:
    run = course(make_plan(stop_at_s=(MOVING_S,)))
    assert not run.end.completed
    assert run.end.state == SafetyState.CAT1
    assert [event.cause for event in run.events] == ["e-stop"]
    assert run.events[0].t_ns == pytest.approx(MOVING_S * 1e9, abs=1_000_001)
    assert at_rest_from(run) < MOVING_S + 0.0011
    assert run.sequence()[-1] == "stopped"
    t_s = run.column("t_ns") * 1e-9
    after = t_s > MOVING_S + 0.0011
    assert (run.column("safety_state")[after] == SafetyState.CAT1).all()
    assert not run.column("tau_nm")[after].any()
    assert np.ptp(run.column("path_s")[after]) == 0.0


def test_the_spasm_of_a_stopped_hand_is_braked(make_plan: MakePlan, course: Any) -> None:
    spasm = Fault("spasm", MOVING_S, 5.0, "", 0.15)
    run = course(make_plan("mas2", stop_at_s=(MOVING_S,)), faults=(spasm,))
    assert run.end.state == SafetyState.CAT1
    assert np.rad2deg(np.abs(run.column("dq_rad_s")).max()) < 150.0


def test_pause_and_resume_stay_on_the_path(make_plan: MakePlan, course: Any) -> None:
    plan = make_plan()
    run = course(plan, orders=((MOVING_S, Pause()), (MOVING_S + 2.0, Resume())))
    assert run.end.completed
    t_s, speed = run.column("t_ns") * 1e-9, run.column("path_speed")
    paused = (t_s > MOVING_S + 0.8) & (t_s < MOVING_S + 2.0)
    assert not speed[paused].any()
    straight = course(plan)
    for name in ("q_reference_rad",):
        place = run.column("path_s")[run.moving(0)]
        expected = np.stack(
            [
                np.interp(place, straight.column("path_s")[straight.moving(0)], column[straight.moving(0)])
                for column in straight.column(name).T
            ],
            axis=1,
        )
        np.testing.assert_allclose(run.column(name)[run.moving(0)], expected, atol=1e-4)


def test_a_pause_in_the_return_comes_to_rest_without_a_jump(
    make_plan: MakePlan, fist: Any, course: Any
) -> None:
    plan = make_plan(path=fist(1.5, 20.0, back=False))
    free = course(plan)
    back_s = next(phase.t_ns for phase in free.phases if phase.phase == "return") * 1e-9 + 0.4
    run = course(plan, orders=((back_s, Pause()), (back_s + 1.0, Resume())))
    assert run.end.completed
    steps = np.abs(np.diff(run.column("dq_command_rad_s"), axis=0)).max()
    assert steps < 0.02
    t_s = run.column("t_ns") * 1e-9
    paused = (t_s > back_s + 0.3) & (t_s < back_s + 1.0)
    assert not run.column("dq_command_rad_s")[paused].any()


def test_speed_can_be_lowered_but_not_raised_above_the_prescription(make_plan: MakePlan, course: Any) -> None:
    slow = course(make_plan(), orders=((0.0, SetSpeed(0.2)),))
    assert slow.column("path_speed").max() <= 0.2 + 1e-6
    fast = course(make_plan(), orders=((0.0, SetSpeed(1.0)),))
    assert fast.column("path_speed").max() <= 0.5 + 1e-6
    with pytest.raises(Refused, match="speed"):
        SetSpeed(1.5)


def test_pain_holds_and_only_a_reset_and_a_new_enable_go_on(make_plan: MakePlan, course: Any) -> None:
    orders = (
        (MOVING_S, Pain()),
        (MOVING_S + 1.0, Resume()),  # refused: not reset
        (MOVING_S + 2.0, Reset()),
        (MOVING_S + 4.0, Resume()),
    )
    run = course(make_plan(), orders=orders)
    assert run.end.completed
    causes = [event.cause for event in run.events]
    assert causes[0] == "pain"
    assert "order-refused Resume" in causes
    assert "reset" in causes
    t_s, state = run.column("t_ns") * 1e-9, run.column("safety_state")
    held = (t_s > MOVING_S + 0.01) & (t_s < MOVING_S + 1.9)
    assert (state[held] == SafetyState.HOLD).all()
    waiting = (t_s > MOVING_S + 2.1) & (t_s < MOVING_S + 3.9)
    assert (state[waiting] == SafetyState.READY).all()
    assert not run.column("path_speed")[waiting].any()
    assert run.column("path_s").max() == pytest.approx(2.0, abs=1e-6)


@pytest.mark.parametrize(
    ("fault", "state"),
    [
        (Fault("nan", MOVING_S, joint="index_pip"), SafetyState.CAT0),
        (Fault("sensor-offset", MOVING_S, joint="thumb_ip", size=0.15), SafetyState.CAT0),
        (Fault("freeze", MOVING_S), SafetyState.CAT0),
        (Fault("over-temperature", MOVING_S, size=95.0), SafetyState.CAT1),
        (Fault("device-fault", MOVING_S), SafetyState.CAT1),
    ],
)
def test_device_faults_stop_the_run(
    make_plan: MakePlan, course: Any, fault: Fault, state: SafetyState
) -> None:
    run = course(make_plan(), faults=(fault,))
    assert not run.end.completed
    assert run.end.state == state
    assert run.events[0].t_ns <= (MOVING_S + 0.005) * 1e9


def test_a_spasm_beyond_the_limit_is_followed_and_ends_the_run_if_nobody_comes(
    make_plan: MakePlan, course: Any
) -> None:
    spasm = Fault("spasm", MOVING_S, 1.0, "index_mcp_flexion", 0.9)
    run = course(make_plan(), faults=(spasm,))
    assert not run.end.completed
    assert run.events[0].state in (SafetyState.COMPLIANT, SafetyState.CAT1)
    assert DRIVEN.index("index_mcp_flexion") >= 0


def test_a_pressed_stop_refuses_the_start(make_plan: MakePlan) -> None:
    from robot_iface.build import open_rig
    from robot_iface.runtime import ScriptedInbox, Surroundings, perform

    class Pressed:
        def pressed(self) -> bool:
            return True

    plan = make_plan()
    with pytest.raises(Refused, match="stop"):
        perform(plan, open_rig(plan), Surroundings(Pressed(), lambda message: None, ScriptedInbox()))
