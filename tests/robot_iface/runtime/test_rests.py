"""What follows a repetition: rests, a look at the skin, and the ends of a run."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from robot_iface.runtime import Resume
from robot_iface.runtime.attempt import Attempt
from robot_iface.runtime.dose import Dose
from robot_iface.runtime.fatigue import Fatigue
from robot_iface.types import DeviceState, Plan, Prescription

MakePlan = Callable[..., Plan]


def when_tired(reached: list[float], succeeded: str = "", *, helped: bool = False) -> list[int]:
    """Repetitions after which fatigue shows."""
    fatigue, marks = Fatigue(helped=helped), succeeded or "y" * len(reached)
    return [
        index
        for index, (share, mark) in enumerate(zip(reached, marks, strict=True))
        if fatigue.note(share, succeeded=mark == "y")
    ]


def test_fatigue_is_a_fall_by_a_fifth_against_the_best_five_before() -> None:
    assert when_tired([1.0] * 20) == []
    assert when_tired([0.3] * 20) == [], "weak from the beginning is not tired"
    assert when_tired([1.0] * 5 + [0.82] * 10) == []
    assert when_tired([1.0] * 5 + [0.75] * 5) == [9], "five at three quarters, not one"
    assert when_tired([1.0] * 5 + [0.0]) == [], "one in five is 80 %, not below"
    assert when_tired([1.0] * 5 + [0.0, 0.0]) == [6]
    assert when_tired([0.5] * 5 + [1.0] * 5 + [0.7] * 5) == [13, 14], "against the best, not the first"


def test_fatigue_is_success_that_falls_below_half() -> None:
    assert when_tired([1.0] * 10, "yyyyynnnyy")[0] == 7
    assert when_tired([1.0] * 10, "yyyyynynyn") == [9]
    assert when_tired([1.0] * 10, "n" * 10) == []


def test_where_the_robot_helps_less_effort_is_fatigue_only_where_it_also_fails() -> None:
    assert when_tired([0.2] * 5 + [0.12] * 5, helped=True) == []
    assert when_tired([0.2] * 5 + [0.12] * 5, "n" * 10, helped=True) == [7, 8, 9]
    assert when_tired([0.02] * 5 + [0.01] * 5, "n" * 10, helped=True) == [], "nothing that could fall"


def test_a_rest_begins_to_count_anew_but_the_best_stays_the_measure() -> None:
    fatigue = Fatigue(helped=False)
    for share in [1.0] * 5 + [0.7] * 5:
        tired = fatigue.note(share, succeeded=True)
    assert tired
    fatigue.rested()
    assert [fatigue.note(0.7, succeeded=True) for _ in range(5)] == [False] * 4 + [True]
    fatigue.rested()
    assert not any(fatigue.note(0.9, succeeded=True) for _ in range(5))


def attempt_of(plan: Plan, made: float, behind: float, push_nm: float) -> Attempt:
    """An attempt in which a share of the target is made, late, with the robot pushing that hard."""
    attempt = Attempt(plan, np.ones(12))
    attempt.begin()
    for tick in range(2000):
        target = np.full(12, min(tick / 1500, 1.0))
        q = np.maximum(made * target - behind, 0.0)
        load = np.full(12, push_nm)
        attempt.watch(DeviceState(0, 0, q, q, q, load, load, 30.0, ()), target)
    return attempt


def test_own_effort_is_the_range_or_where_helped_how_far_the_hand_leads(make_plan: MakePlan) -> None:
    helped, alone = make_plan(mode="assistive"), make_plan(mode="transparent")
    assert attempt_of(alone, 0.5, 0.0, 0.2).reached("patient") == pytest.approx(0.5, abs=0.02)
    assert attempt_of(helped, 1.0, -0.1, 0.0).reached("patient") == pytest.approx(0.1, abs=0.01)
    assert attempt_of(helped, 1.0, -0.1, 0.2).reached("patient") == pytest.approx(0.1, abs=0.01)
    assert attempt_of(helped, 1.0, 0.1, 0.0).reached("patient") == 0.0, "left behind"
    assert attempt_of(helped, 1.0, -0.1, 0.0).reached("robot") == 0.0, "the robot began"


def test_success_is_started_reached_and_not_left_behind(make_plan: MakePlan) -> None:
    helped = make_plan(mode="assistive")
    assert attempt_of(helped, 1.0, 0.02, 0.0).succeeded("patient")
    assert not attempt_of(helped, 1.0, 0.02, 0.0).succeeded("robot")
    assert not attempt_of(helped, 0.7, 0.0, 0.0).succeeded("patient")
    assert not attempt_of(helped, 1.0, 0.15, 0.0).succeeded("patient"), "late all the way"
    assert attempt_of(make_plan(mode="resistive"), 1.0, 0.15, 0.0).succeeded("patient")


def test_no_new_repetition_begins_when_the_minutes_are_over(
    make_plan: MakePlan, fist: Any, course: Any
) -> None:
    run = course(make_plan(repetitions=50, minutes=0.25, path=fist(1.0, 6.0, 20.0)))
    assert run.end.completed
    assert run.end.reason == "minutes"
    last = max(phase.repetition for phase in run.phases)
    begun = next(phase.t_ns for phase in run.phases if phase.repetition == last) * 1e-9
    assert begun < 15.0 + 1.5
    assert run.end.simulated_s > 15.0


def test_a_run_that_made_every_repetition_says_so(make_plan: MakePlan, course: Any) -> None:
    run = course(make_plan())
    assert run.end.reason == "repetitions"
    assert run.end.reversals == 0
    assert run.end.scheduling == "simulated time"
    stopped = course(make_plan(stop_at_s=(4.0,)))
    assert stopped.end.reason == "e-stop"
    assert not stopped.end.completed


def test_the_dose_leaves_pauses_and_rests_out() -> None:
    dose = Dose(Prescription("passive", minutes=0.5, skin_check_s=20.0), 4.0, 1.0, 0.01)
    for _ in range(1500):
        dose.tick(moving=True, repeating=False)
    for _ in range(1490):
        dose.tick(moving=False, repeating=False)
    assert not dose.skin_check_due
    assert not dose.minutes_over
    for _ in range(500):
        dose.tick(moving=True, repeating=True)
    assert dose.skin_check_due
    assert dose.minutes_over
    assert dose.repetition_ns == 5_000_000_000
    dose.skin_checked()
    dose.next_repetition()
    assert not dose.skin_check_due
    assert dose.repetition_ns == 0
    before = dose.timeout_ns
    dose.slowed_to(0.25)
    assert dose.timeout_ns - before == 16_000_000_000


def test_a_skin_check_in_a_run_can_be_followed_by_the_rest_of_it(
    make_plan: MakePlan, fist: Any, course: Any
) -> None:
    plan = make_plan(repetitions=3, skin_check_s=2.5, path=fist(1.0, 6.0, 20.0))
    run = course(plan, orders=((30.0, Resume()), (60.0, Resume())))
    assert run.end.completed
    assert [event.cause for event in run.events] == ["skin-check", "skin-check"]
    assert run.sequence().count("skin-check") == 2
