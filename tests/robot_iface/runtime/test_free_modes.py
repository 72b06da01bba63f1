"""Transparent and resistive: the patient moves, the robot never does."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from robot_iface.safety import shipped_limits
from robot_iface.sim import DRIVEN, VirtualPatient
from robot_iface.types import Float64, Hull, Plan

MakePlan = Callable[..., Plan]
MCP = [DRIVEN.index(f"{finger}_mcp_flexion") for finger in ("index", "middle", "ring", "little")]


def free_from(run: Any, repetition: int = 0) -> Float64:
    """Ticks of the movement after the hand has been let go of."""
    moving = run.moving(repetition)
    moving[np.flatnonzero(moving)[:600]] = False
    return moving


@pytest.mark.parametrize("mode", ["transparent", "resistive"])
def test_the_patient_starts_and_makes_the_movement_alone(make_plan: MakePlan, course: Any, mode: str) -> None:
    run = course(make_plan("healthy", mode))
    assert run.sequence() == ["approach", "ramp", "cue", "move", "hold", "return", "done"]
    assert run.started_by(0) == {"patient"}
    assert run.end.completed
    assert not run.events
    moving = run.moving(0)
    asked = np.ptp(run.column("q_reference_rad")[moving], axis=0)
    made = np.ptp(run.column("q_rad")[moving], axis=0)
    assert (made[MCP] > 0.8 * asked[MCP]).all()


@pytest.mark.parametrize("kind", ["healthy", "tremor"])
def test_a_transparent_robot_is_hardly_felt(make_plan: MakePlan, course: Any, kind: str) -> None:
    run = course(make_plan(kind, "transparent"))
    assert run.end.completed
    felt = run.column("tau_interaction_nm")[free_from(run)]
    assert np.sqrt((felt**2).mean()) < (0.0075 if kind == "healthy" else 0.02)


@pytest.mark.parametrize("mode", ["transparent", "resistive"])
def test_a_hand_that_does_nothing_is_not_moved(
    make_plan: MakePlan, fist: Any, course: Any, mode: str
) -> None:
    """It rests where the path begins, so nothing recoils either; the target passes by."""
    plan = make_plan("flaccid", mode, cue_timeout_s=1.0)
    rest = np.rad2deg(course(make_plan("flaccid")).column("q_rad")[5])
    t_s = plan.path.t_s
    q = np.tile(np.deg2rad(rest), (t_s.size, 1)) + (plan.path.q_rad - plan.path.q_rad[0])
    run = course(replace(plan, path=replace(plan.path, q_rad=q)))
    assert run.started_by(0) == {"robot"}
    assert run.end.completed
    moving = run.moving(0)
    assert np.rad2deg(np.ptp(run.column("q_reference_rad")[moving], axis=0)).max() > 20.0
    assert np.rad2deg(np.ptp(run.column("q_rad")[moving], axis=0)).max() < 0.5


@pytest.mark.parametrize(
    ("mode", "kind"), [("transparent", "healthy"), ("resistive", "healthy"), ("resistive", "weak")]
)
def test_the_robot_takes_energy_and_never_gives_any(
    make_plan: MakePlan, course: Any, mode: str, kind: str
) -> None:
    run = course(make_plan(kind, mode))
    free = free_from(run)
    power = (run.column("tau_applied_nm") * run.column("dq_rad_s"))[free]
    work = power.sum(axis=0) * 1e-3
    if mode == "resistive":
        assert power.max() < 2e-3, "it only ever opposes"
        assert work.max() < 0.0
    assert np.cumsum(power.sum(axis=1)).max() * 1e-3 < 2e-3


def test_more_resistance_opposes_more_and_moves_less(make_plan: MakePlan, course: Any) -> None:
    loads, ranges = [], []
    for resistance in (0.1, 0.5):
        run = course(make_plan("healthy", "resistive", resistance=resistance))
        assert run.end.completed
        loads.append(run.rms_interaction_nm(0))
        ranges.append(np.ptp(run.column("q_rad")[run.moving(0)], axis=0)[MCP].mean())
    assert loads[1] > 1.2 * loads[0]
    assert ranges[1] < ranges[0]


def test_soft_walls_end_todays_range_for_a_hand_that_is_free(
    make_plan: MakePlan, fist: Any, course: Any
) -> None:
    """A strong patient strives for 45 degrees where today ends at 34: held by the wall, not tripped."""
    limits = shipped_limits(DRIVEN, np.zeros(12), np.full(12, np.deg2rad(34.0)))
    plan = replace(make_plan("healthy", "transparent", path=fist(3.0, 37.0, 8.0)), limits=limits)
    run = course(plan, patient=VirtualPatient(0.040, ability=1.0, will="follow"))
    assert run.end.completed
    assert not run.events
    reached = np.rad2deg(run.column("q_rad").max())
    assert 34.5 < reached < 36.0
    assert np.abs(run.column("tau_interaction_nm")).max() > 0.04


def test_a_wall_stands_on_the_edge_of_a_coupled_range_too(make_plan: MakePlan) -> None:
    from robot_iface.runtime.shaper import Shaper

    plan = make_plan("healthy", "transparent")
    corners = np.deg2rad([[0.0, 0.0], [60.0, 0.0], [60.0, 10.0], [0.0, 60.0]])
    hull = Hull(("index_mcp_flexion", "index_pip"), corners)
    shaper = Shaper(replace(plan, limits=replace(plan.limits, hulls=(hull,))), 1.0, 1e-3)
    shaper.begin_anew(0.0)
    mcp, pip = DRIVEN.index("index_mcp_flexion"), DRIVEN.index("index_pip")
    inside = np.full(12, np.deg2rad(20.0))
    still = np.zeros(12)
    setpoint, multiple = shaper.let_go(inside, still)
    assert np.array_equal(setpoint.q_rad, inside)
    assert not multiple.any()
    beyond = inside.copy()
    beyond[[mcp, pip]] = np.deg2rad([50.0, 40.0])
    setpoint, multiple = shaper.let_go(beyond, still)
    push = setpoint.q_rad - beyond
    assert push[mcp] < 0.0
    assert push[pip] < 0.0
    assert multiple[mcp] * 0.3 == multiple[pip] * 0.4 == pytest.approx(3.0)
    assert not multiple[[j for j in range(12) if j not in (mcp, pip)]].any()
    swift, damped = shaper.let_go(inside, np.full(12, 3.0))
    assert np.array_equal(swift.q_rad, inside), "damping has no spring to it"
    assert (damped > 0.0).all()


def test_assistance_is_carried_over_and_reported(make_plan: MakePlan, course: Any) -> None:
    first = course(make_plan("healthy", "assistive", repetitions=2))
    assert [len(row) for row in first.end.assistance] == [5, 5]
    assert max(first.end.assistance[1]) < 3.0
    again = course(make_plan("healthy", "assistive", repetitions=1, assistance=first.end.assistance))
    assert again.multiple(0) < 0.8 * first.multiple(0)
    assert course(make_plan()).end.assistance == ()
