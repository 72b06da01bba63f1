"""Pause, reverse and resume: every set-point lies on the path, and no speed passes its directed limit."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from robot_iface.motion import QuinticPath
from robot_iface.runtime import Advance, Pause, Resume, Reverse, SetSpeed
from robot_iface.safety import shipped_limits
from robot_iface.sim import DRIVEN, device_capabilities
from robot_iface.types import Float64, Plan

MakePlan = Callable[..., Plan]


def on_path(plan: Plan, run: Any, moving: Float64) -> float:
    """Largest distance of the reference from q(s) at the recorded coordinate, rad."""
    here = QuinticPath(plan.path).sample(run.column("path_s")[moving])
    return float(np.abs(run.column("q_reference_rad")[moving] - here).max())


@pytest.mark.parametrize("speed", [0.25, 0.5, 1.0])
def test_set_points_lie_on_the_path_through_pause_resume_reverse_and_change_of_speed(
    make_plan: MakePlan, fist: Any, course: Any, speed: float
) -> None:
    plan = make_plan("flaccid", speed=speed, path=fist(6.0, 30.0, 8.0))
    begun = next(p.t_ns for p in course(plan, orders=((3.9, Pause()),)).phases if p.phase == "move") * 1e-9
    second = 1.0 / speed
    orders = (
        (begun + 1.2 * second, Pause()),
        (begun + 1.2 * second + 0.9, Resume()),
        (begun + 2.2 * second + 0.9, Reverse()),
        (begun + 2.7 * second + 0.9, SetSpeed(max(0.1, 0.6 * speed))),
        (begun + 3.2 * second + 0.9, Resume()),
        (begun + 3.4 * second + 0.9, SetSpeed(speed)),
    )
    run = course(plan, orders)
    assert run.end.completed
    assert not run.events
    moving = run.moving(0)
    s, s_dot = run.column("path_s")[moving], run.column("path_speed")[moving]
    assert s_dot.min() < -0.1 * speed, "it did go back"
    assert s[-1] == pytest.approx(6.0, abs=1e-3)
    assert on_path(plan, run, moving) < 1e-6
    assert np.abs(s_dot).max() <= speed + 1e-9
    s_ddot = np.diff(s_dot) / 1e-3
    assert np.abs(s_ddot).max() <= 2.0 + 1e-6
    assert np.abs(np.diff(s_ddot)).max() / 1e-3 <= 20.0 + 1e-3


def test_the_commanded_position_lies_on_the_path_where_the_spring_does_not_saturate(
    make_plan: MakePlan, course: Any
) -> None:
    plan = make_plan("flaccid")
    run = course(plan, orders=((4.0, Reverse()), (6.5, Resume())))
    moving = run.moving(0)
    apart = np.abs(run.column("q_command_rad") - run.column("q_reference_rad"))[moving]
    assert apart.max() < 1e-9
    assert run.column("path_speed").min() < 0.0


@pytest.mark.parametrize("closing", [True, False])
def test_a_reverse_obeys_the_speed_limit_of_the_direction_in_which_the_joints_then_move(
    make_plan: MakePlan, fist: Any, course: Any, closing: bool
) -> None:
    """A spastic hand may close at 60 and open at 15 deg/s; the path closes at about 45."""
    path = fist(4.0, 38.0 if closing else -38.0, 8.0 if closing else 46.0)
    device = device_capabilities()
    limits = shipped_limits(DRIVEN, device.q_min_rad, device.q_max_rad, spastic=True)
    speed = 1.0 if closing else 0.25
    plan = replace(make_plan("flaccid", speed=speed, path=path), limits=limits)
    half_way = 2.0 + 2.6 + 1.4 / speed
    run = course(
        plan, orders=((half_way, Reverse()), (half_way + 0.5, Resume()), (half_way + 1.0, Reverse()))
    )
    moving = run.moving(0)
    rate, s_dot = run.column("dq_command_rad_s")[moving], run.column("path_speed")[moving]
    back = s_dot < 0.0
    assert back.any()
    assert (rate[back] <= limits.flexion_speed_rad_s + 1e-9).all()
    assert (-rate[back] <= limits.extension_speed_rad_s + 1e-9).all()
    assert run.column("path_s")[moving][-1] == 0.0, "it waits at the start for a resume"
    assert run.end.reason == "unattended"


def test_a_reverse_at_the_held_end_goes_back_and_resumes(make_plan: MakePlan, fist: Any, course: Any) -> None:
    plan = make_plan("flaccid", hold_s=2.0, path=fist(2.0, 20.0, back=False))
    plain = course(plan)
    held = next(phase.t_ns for phase in plain.phases if phase.phase == "hold") * 1e-9
    run = course(plan, orders=((held + 0.5, Reverse()), (held + 1.5, Resume())))
    assert run.end.completed
    assert run.sequence() == ["approach", "ramp", "move", "hold", "move", "hold", "return", "done"]
    assert on_path(plan, run, run.moving(0)) < 1e-6


def test_a_reverse_elsewhere_is_a_pause_and_on_the_way_back_changes_nothing(
    make_plan: MakePlan, fist: Any, course: Any
) -> None:
    plan = make_plan("flaccid", repetitions=2, rest_s=1.0, path=fist(1.5, 20.0, back=False))
    plain = course(plan)
    times = {phase.phase: phase.t_ns * 1e-9 for phase in reversed(plain.phases) if phase.repetition == 0}
    back = course(plan, orders=((times["return"] + 0.2, Reverse()),))
    assert back.end.simulated_s == plain.end.simulated_s
    rest = course(plan, orders=((times["rest"] + 0.2, Reverse()), (times["rest"] + 3.0, Resume())))
    assert rest.end.simulated_s > plain.end.simulated_s + 1.5


def test_a_person_may_ask_for_what_comes_next(make_plan: MakePlan, course: Any) -> None:
    plan = make_plan("flaccid", "assistive", repetitions=2, rest_s=20.0, hold_s=20.0)
    orders = ((1.0, Advance()), (5.0, Advance()), (12.0, Advance()), (16.0, Advance()))
    run = course(plan, orders)
    assert [event.cause for event in run.events] == ["order-refused next repetition"]
    times = {phase.phase: phase.t_ns * 1e-9 for phase in reversed(run.phases) if phase.repetition == 0}
    assert times["move"] == pytest.approx(5.0, abs=0.01)
    assert run.started_by(0) == {"robot"}
    assert times["return"] == pytest.approx(12.0, abs=0.01)
    assert next(p.t_ns for p in run.phases if p.repetition == 1) * 1e-9 == pytest.approx(16.0, abs=0.01)
