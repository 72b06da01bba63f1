"""Assistive runs: who starts, how help follows ability, and that the ahead are left alone."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from robot_iface.sim import VirtualPatient, virtual_patient
from robot_iface.types import Plan

MakePlan = Callable[..., Plan]


def test_a_patient_with_some_ability_starts_and_the_robot_completes(make_plan: MakePlan, course: Any) -> None:
    run = course(make_plan("weak", "assistive"))
    assert run.sequence() == ["approach", "ramp", "cue", "move", "hold", "return", "done"]
    assert run.started_by(0) == {"patient"}
    assert run.end.completed
    assert not run.events


def test_without_intention_the_robot_starts_after_the_time_out(make_plan: MakePlan, course: Any) -> None:
    plan = make_plan("flaccid", "assistive")
    plan = replace(plan, prescription=replace(plan.prescription, cue_timeout_s=2.0))
    run = course(plan)
    assert run.started_by(0) == {"robot"}
    cue = [phase.t_ns for phase in run.phases if phase.phase == "cue"]
    assert (cue[-1] - cue[0]) * 1e-9 > 1.7


def test_assistance_falls_from_repetition_to_repetition_for_the_able(
    make_plan: MakePlan, course: Any
) -> None:
    run = course(make_plan("healthy", "assistive", repetitions=3))
    multiples = [run.multiple(repetition) for repetition in range(3)]
    assert multiples[0] > multiples[1] > multiples[2]


def test_the_robots_share_falls_as_ability_grows(make_plan: MakePlan, course: Any) -> None:
    shares, multiples = [], []
    for ability in (0.0, 0.9):
        patient = VirtualPatient(0.12, ability=ability, will="follow", flexed=True)
        plan = make_plan("mas1+", "assistive", repetitions=2, multiple=2.0)
        plan = replace(plan, prescription=replace(plan.prescription, cue_timeout_s=1.0))
        run = course(plan, patient=patient)
        assert run.end.completed
        shares.append(run.rms_interaction_nm(1))
        multiples.append(run.multiple(1))
    assert shares[0] > shares[1]
    assert multiples[0] > multiples[1]


def test_nobody_who_is_ahead_is_pulled_back(make_plan: MakePlan, course: Any) -> None:
    run = course(make_plan("healthy", "assistive"))
    moving = run.moving(0)
    early = moving & (run.column("path_s") < 0.4)
    pull = run.column("tau_interaction_nm")[early]
    ahead = run.column("q_rad")[early] - run.column("q_reference_rad")[early]
    assert np.rad2deg(ahead.max()) > 2.0
    assert pull.min() > -0.05


def test_a_spastic_hand_is_assisted_without_a_stop(make_plan: MakePlan, fist: Any, course: Any) -> None:
    run = course(make_plan("mas2", "assistive", path=fist(5.0, 30.0, 5.0)))
    assert run.end.completed
    assert not run.events
    assert virtual_patient("mas2").flexed


def test_the_second_repetition_begins_without_a_push_and_nothing_is_learnt_from_the_ahead(
    make_plan: MakePlan, fist: Any, course: Any
) -> None:
    """A weak patient at three times the thesis gains runs ahead: that must not turn into a push."""
    plan = make_plan("weak", "assistive", repetitions=3, path=fist(3.0, 25.0, 1.0))
    run = course(plan)
    assert run.end.completed
    assert not run.events
    push = run.column("tau_ff_nm")
    assert np.abs(np.diff(push, axis=0)).max() <= 0.5e-3 + 1e-9
    for repetition in (1, 2):
        moving = run.moving(repetition)
        assert np.abs(push[moving][:50]).max() < 1e-3
        assert np.abs(push[moving][-50:]).max() < 5e-3
    below = plan.limits.q_min_rad - run.column("q_rad")
    assert np.rad2deg(below.max()) < 0.5
