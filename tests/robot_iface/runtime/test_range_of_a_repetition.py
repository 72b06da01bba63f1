"""Warm-up and reversals: how much of the range is asked for in each repetition."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from robot_iface.motion import QuinticPath
from robot_iface.runtime.allowance import Allowance
from robot_iface.runtime.exercise import Exercise
from robot_iface.runtime.orders import PresentPatient
from robot_iface.runtime.reversals import Reversals, Verdict
from robot_iface.safety import shipped_limits
from robot_iface.sim import DRIVEN
from robot_iface.types import DeviceState, Hull, Plan, Spasm

MakePlan = Callable[..., Plan]
MCP, PIP = DRIVEN.index("index_mcp_flexion"), DRIVEN.index("index_pip")


def tight(plan: Plan, low_deg: float = 6.0, high_deg: float = 33.0) -> Plan:
    """The plan with a measured range that the path nearly fills."""
    low, high = np.full(12, np.deg2rad(low_deg)), np.full(12, np.deg2rad(high_deg))
    return replace(plan, limits=shipped_limits(DRIVEN, low, high))


def asked_deg(run: Any, repetition: int, joint: int = PIP) -> tuple[float, float]:
    """Least and greatest angle asked for in a repetition's movement."""
    q = np.rad2deg(run.column("q_reference_rad")[run.moving(repetition)][:, joint])
    return float(q.min()), float(q.max())


def test_the_warm_up_ends_ten_degrees_before_the_limits_and_two_nearer_each_time(
    make_plan: MakePlan, fist: Any, course: Any
) -> None:
    plan = tight(make_plan(repetitions=4, warm_up_repetitions=3, path=fist(2.0, 22.0, 8.0)))
    run = course(plan)
    assert run.end.completed
    assert not run.events
    for repetition, margin in enumerate((10.0, 8.0, 6.0)):
        low, high = asked_deg(run, repetition)
        assert low == pytest.approx(6.0 + margin, abs=0.01)
        assert high == pytest.approx(min(33.0 - margin, 30.0), abs=0.01)
    assert asked_deg(run, 3) == pytest.approx((8.0, 30.0), abs=0.01)


def test_the_warm_up_is_never_faster_and_never_jumps(make_plan: MakePlan, fist: Any, course: Any) -> None:
    path = fist(2.0, 22.0, 8.0)
    plain = course(tight(make_plan(path=path)))
    run = course(tight(make_plan(repetitions=3, warm_up_repetitions=3, path=path)))
    fastest = np.abs(plain.column("dq_command_rad_s")[plain.moving(0)]).max(axis=0)
    for repetition in range(3):
        rate = np.abs(run.column("dq_command_rad_s")[run.moving(repetition)]).max(axis=0)
        assert (rate <= fastest + 1e-9).all()
    assert np.abs(np.diff(run.column("dq_command_rad_s"), axis=0)).max() < 0.02
    bench = Bench(tight(make_plan(repetitions=3, warm_up_repetitions=3, path=path)))
    bench.run(lambda ex: ex.done)  # it checks every set-point


def test_a_path_far_from_the_limits_is_not_narrowed(make_plan: MakePlan, course: Any) -> None:
    whole = course(make_plan(repetitions=2))
    warm = course(make_plan(repetitions=2, warm_up_repetitions=2))
    assert asked_deg(warm, 0) == pytest.approx(asked_deg(whole, 0), abs=3.0)
    np.testing.assert_array_equal(
        warm.column("q_reference_rad")[warm.moving(0)][:, PIP] >= np.deg2rad(9.99), True
    )


def test_joints_that_are_coupled_are_narrowed_together(make_plan: MakePlan, fist: Any) -> None:
    """Each joint for itself would leave the band along the diagonal that both may share."""
    t_s = np.linspace(0.0, 2.0, 61)
    u = 0.5 - 0.5 * np.cos(np.pi * t_s)
    q = np.full((61, 12), np.deg2rad(15.0))
    q[:, MCP], q[:, PIP] = np.deg2rad(1.0 + 40.0 * u), np.deg2rad(20.0 + 40.0 * u)
    path = replace(fist(), t_s=t_s, q_rad=q)
    plan = tight(make_plan(path=path, warm_up_repetitions=1), 0.0, 80.0)
    corners = np.deg2rad([[0.0, 18.0], [0.0, 17.0], [60.0, 77.0], [60.0, 82.0], [0.0, 22.0]])[1:]
    hull = Hull(("index_mcp_flexion", "index_pip"), corners)
    coupled = replace(plan, limits=replace(plan.limits, hulls=(hull,)))
    spline = QuinticPath(path)
    apart = Allowance(spline, plan).for_repetition(0)
    together = Allowance(spline, coupled).for_repetition(0)
    assert apart.scale[MCP] < 0.8
    assert apart.scale[PIP] == 1.0
    assert together.scale[MCP] == together.scale[PIP] == pytest.approx(apart.scale[MCP])
    offset = np.rad2deg(np.diff(together.apply(spline.sample(t_s))[:, [MCP, PIP]], axis=1))
    np.testing.assert_allclose(offset, 19.0, atol=1e-6)


@pytest.mark.parametrize(
    ("flags", "verdicts"),
    [
        ("x", "g"),
        ("xx", "gn"),
        ("x...x", "g...n"),
        ("x....x", "g....g"),
        ("xxx", "gns"),
        ("xx..x", "gn..s"),
        ("xx...xx", "gn...nn"),
    ],
)
def test_two_in_five_take_range_off_and_a_third_stops(flags: str, verdicts: str) -> None:
    expected = {"g": Verdict.GO_ON, "n": Verdict.NARROW, "s": Verdict.STOP, ".": Verdict.GO_ON}
    reversals = Reversals()
    given = [reversals.note(reversed_on_load=flag == "x") for flag in flags]
    assert given == [expected[letter] for letter in verdicts]
    assert reversals.count == flags.count("x")


class Bench:
    """An exercise whose hand is always where it is told to be, and on which loads reverse when told to."""

    def __init__(self, plan: Plan) -> None:
        self.exercise = Exercise(plan, PresentPatient(), 1e-3)
        self.q = np.array(plan.path.q_rad[0]) if plan.path is not None else np.zeros(12)
        self.asked: list[tuple[str, int, float]] = []
        self.exercise.begin(self.q)

    def run(self, until: Callable[[Exercise], bool], at_most: int = 60_000) -> None:
        zeros = np.zeros(12)
        for _ in range(at_most):
            state = DeviceState(0, 0, self.q, self.q, zeros, zeros, zeros, 30.0, ())
            before = self.q
            self.q = self.exercise.step(state, 0.0, True).setpoint.q_rad
            assert np.abs(self.q - before).max() < 2e-3, "the set-point jumped"
            self.asked.append((self.exercise.phase, self.exercise.repetition, float(self.q[PIP])))
            if until(self.exercise):
                return
        raise AssertionError("never came to it")

    def reverse_in(self, repetition: int, s: float) -> None:
        """A load reverses this repetition at a path coordinate: the hand is led 5 degrees back."""
        self.run(lambda ex: ex.repetition == repetition and ex.phase == "move" and ex.path_state.s >= s)
        self.q = self.q - np.deg2rad(5.0) * np.sign(self.exercise._movement.rate_rad_s)
        self.exercise.reversed_on_load(self.q)

    def span_deg(self, repetition: int) -> tuple[float, float]:
        q = [value for phase, index, value in self.asked if phase == "move" and index == repetition]
        return float(np.rad2deg(min(q))), float(np.rad2deg(max(q)))


def test_a_repetition_in_which_the_load_reversed_is_given_up_and_the_next_is_whole(
    make_plan: MakePlan,
) -> None:
    bench = Bench(make_plan(repetitions=3))
    bench.reverse_in(0, 0.8)
    assert bench.exercise.phase == "return"
    bench.run(lambda ex: ex.done)
    assert bench.exercise.reason == "repetitions"
    assert bench.span_deg(0)[1] < 29.0, "it was given up"
    assert bench.span_deg(1) == pytest.approx((8.0, 30.0), abs=0.01)


@pytest.mark.parametrize(("s", "expected"), [(0.6, (8.0, 25.0)), (1.4, (13.0, 30.0))])
def test_after_two_reversals_five_degrees_are_taken_off_the_end_that_was_headed_for(
    make_plan: MakePlan, s: float, expected: tuple[float, float]
) -> None:
    """The path closes in its first half and opens in its second."""
    bench = Bench(make_plan(repetitions=4))
    bench.reverse_in(0, s)
    bench.reverse_in(1, s)
    bench.run(lambda ex: ex.done)
    for repetition in (2, 3):
        assert bench.span_deg(repetition) == pytest.approx(expected, abs=0.01)


def test_a_third_reversal_in_five_asks_for_a_stop(make_plan: MakePlan) -> None:
    bench = Bench(make_plan(repetitions=5))
    for repetition in range(3):
        bench.reverse_in(repetition, 0.7)
    assert bench.exercise.reason == "reversals"
    assert not bench.exercise.done


def test_a_reversal_on_the_approach_leads_there_anew(make_plan: MakePlan) -> None:
    plan = make_plan()
    bench = Bench(plan)
    bench.q = bench.q + 0.2
    bench.exercise.begin(bench.q)
    for _ in range(200):
        bench.run(lambda ex: True)
    bench.exercise.reversed_on_load(bench.q)
    bench.run(lambda ex: ex.done)
    assert bench.span_deg(0) == pytest.approx((8.0, 30.0), abs=0.01)


def reversing(make_plan: MakePlan, fist: Any, times: tuple[float, ...]) -> Plan:
    """An opening and closing in which a short spasm of one joint opposes the opening at these times.

    It rises in two steps: one step of all of it throws the finger at the trip speed before it loads it.
    """
    plan = make_plan(multiple=10.0, repetitions=6, rest_s=0.5, path=fist(4.0, -18.0, 30.0))
    steps = ((0.0, 0.12), (0.06, 0.06))
    spasms = tuple(
        Spasm(time + later, lasts, 0.14, "index_mcp_flexion") for time in times for later, lasts in steps
    )
    return replace(plan, twin=replace(plan.twin, spasms=spasms))


def test_three_spasms_narrow_and_then_stop_the_run(make_plan: MakePlan, fist: Any, course: Any) -> None:
    times: tuple[float, ...] = (6.0,)
    for repetition in (1, 2):
        run = course(reversing(make_plan, fist, times))
        assert run.end.reversals == repetition
        begun = [
            next(p.t_ns for p in run.phases if p.phase == "move" and p.repetition == index) * 1e-9
            for index in (0, repetition)
        ]
        times = (*times, times[0] + begun[1] - begun[0])
    low, high = asked_deg(run, 3, MCP)
    assert high - low == pytest.approx(13.0, abs=0.01)
    run = course(reversing(make_plan, fist, times))
    causes = [event.cause for event in run.events]
    assert causes == ["reversal", "reversal", "range-narrowed", "reversal", "reversals"]
    assert run.end.reason == "reversals"
    assert run.end.reversals == 3
    assert not run.end.completed
