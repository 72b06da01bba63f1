"""Passive runs: order of phases, error against stiffness, learning, limits, determinism."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from robot_iface.errors import Refused
from robot_iface.runtime import Pain, Reset, Resume
from robot_iface.safety import shipped_limits
from robot_iface.sim import DRIVEN, VirtualPatient, virtual_patient
from robot_iface.types import Plan, RunEnd, SafetyState, TickBlock

MakePlan = Callable[..., Plan]


def test_phases_come_in_order_and_every_tick_is_recorded(make_plan: MakePlan, course: Any) -> None:
    run = course(make_plan(repetitions=2))
    once = ["ramp", "move", "hold", "return"]
    assert run.sequence() == ["approach", *once, "rest", *once, "done"]
    assert run.end.completed
    assert run.end.state in (SafetyState.READY, SafetyState.OFF)
    t_ns = run.column("t_ns")
    assert set(np.diff(t_ns).tolist()) == {1_000_000}
    blocks = [message for message in run.messages if isinstance(message, TickBlock)]
    assert {block.t_ns.size for block in blocks[:-1]} == {50}
    assert isinstance(run.messages[-1], RunEnd)
    phase_gaps = np.diff([phase.t_ns for phase in run.phases])
    assert phase_gaps.max() <= 100_000_000


def test_the_path_coordinate_covers_the_whole_path_in_each_repetition(
    make_plan: MakePlan, course: Any
) -> None:
    plan = make_plan(repetitions=2)
    run = course(plan)
    for repetition in range(2):
        path_s = run.column("path_s")[run.moving(repetition)]
        assert path_s[0] < 0.01
        assert path_s[-1] == pytest.approx(plan.path.t_s[-1], abs=1e-3)
        assert (np.diff(path_s) >= 0.0).all()


def test_a_stiffer_robot_follows_better(make_plan: MakePlan, course: Any) -> None:
    errors = [course(make_plan(multiple=multiple)).rmse_deg(0) for multiple in (1.0, 3.0, 10.0)]
    assert errors[0] > errors[1] > errors[2]
    assert 0.5 < errors[0] < 5.0
    assert errors[2] <= 1.0


def test_a_stiffer_hand_is_followed_worse(make_plan: MakePlan, course: Any) -> None:
    errors = [course(make_plan(kind)).rmse_deg(0) for kind in ("flaccid", "healthy", "mas1+", "mas2")]
    assert errors == sorted(errors)


def test_learning_reduces_the_error_from_repetition_to_repetition(make_plan: MakePlan, course: Any) -> None:
    run = course(make_plan("mas1+", repetitions=3))
    errors = [run.rmse_deg(repetition) for repetition in range(3)]
    assert errors[1] < 0.35 * errors[0]
    assert errors[2] < 0.12 * errors[0], "no floor at the ends of the path"
    push = np.abs(run.column("tau_ff_nm"))
    assert push.max() > 0.05
    assert np.abs(np.diff(push, axis=0)).max() <= 0.5e-3 + 1e-9, (
        "it never steps, at the end of the run either"
    )


def test_what_was_learnt_is_gone_at_once_after_pain(make_plan: MakePlan, course: Any) -> None:
    plan = make_plan("mas1+", repetitions=2)
    second = [phase.t_ns * 1e-9 for phase in course(plan).phases if phase.repetition == 1]
    move_s = second[0] + plan.prescription.ramp_s + 1.5
    orders = ((move_s, Pain()), (move_s + 3.0, Reset()), (move_s + 3.5, Resume()))
    run = course(plan, orders)
    assert {event.cause for event in run.events} == {"pain", "reset"}
    assert run.end.completed
    t_s = run.column("t_ns") * 1e-9
    push = np.abs(run.column("tau_ff_nm")).max(axis=1)
    assert push[t_s < move_s].max() > 0.02
    assert push[t_s > move_s + 4.0].max() == 0.0


def test_a_spastic_hand_within_the_shipped_limits_opens_in_part_and_the_run_goes_on(
    make_plan: MakePlan, fist: Any, course: Any
) -> None:
    run = course(make_plan("mas3", path=fist(6.0, 40.0, 4.0)))
    assert run.end.completed
    assert not run.events
    load = np.abs(run.column("tau_interaction_nm")).max(axis=0)
    limit = make_plan("mas3").limits.tau_interaction_nm
    assert (load <= limit).all()
    assert (load > 0.85 * limit).any()


def test_stiffening_against_a_stiff_hand_does_not_tear_at_it(
    make_plan: MakePlan, fist: Any, course: Any
) -> None:
    run = course(make_plan("mas3", multiple=10.0, path=fist(6.0, 40.0, 5.0)))
    assert run.end.completed
    assert not run.events
    assert -np.rad2deg(run.column("dq_rad_s").min()) < 40.0


def test_applied_torque_never_passes_the_cap(make_plan: MakePlan, course: Any) -> None:
    plan = make_plan("mas2", multiple=10.0)
    applied = np.abs(course(plan).column("tau_applied_nm")).max(axis=0)
    assert (applied <= plan.limits.tau_nm).all()


def test_the_same_seed_gives_the_same_digest_and_another_another(
    make_plan: MakePlan, fist: Any, course: Any
) -> None:
    digests = [
        course(make_plan("tremor", seed=seed, path=fist(1.0, 6.0, 20.0))).end.digest for seed in (5, 5, 6)
    ]
    assert digests[0] == digests[1] != digests[2]
    assert len(digests[0]) == 64


def test_both_sides_are_followed_alike(make_plan: MakePlan, course: Any) -> None:
    errors = [course(make_plan(side=side)).rmse_deg(0) for side in ("left", "right")]
    assert errors[0] == pytest.approx(errors[1], rel=1e-3)


def test_a_path_that_ends_elsewhere_is_brought_back_at_the_permitted_speed(
    make_plan: MakePlan, fist: Any, course: Any
) -> None:
    plan = make_plan(path=fist(1.5, 20.0, back=False))
    run = course(plan)
    assert run.end.completed
    command = run.column("dq_command_rad_s")
    assert -command.min() <= plan.limits.extension_speed_rad_s.max() + 1e-9
    np.testing.assert_allclose(run.column("q_reference_rad")[-1], plan.path.q_rad[0], atol=1e-6)


def test_a_path_for_other_joints_is_refused(make_plan: MakePlan, course: Any) -> None:
    plan = make_plan()
    path = plan.path
    other = type(path)((*DRIVEN[1:], DRIVEN[0]), path.t_s, path.q_rad, path.take_digest, path.side)
    with pytest.raises(Refused, match="reference path joints"):
        course(make_plan(path=other))


def test_a_hand_outside_todays_range_is_not_enabled(make_plan: MakePlan, course: Any) -> None:
    from dataclasses import replace

    plan = make_plan()
    low = np.full(12, np.deg2rad(-20.0))
    tight = shipped_limits(DRIVEN, low, np.full(12, np.deg2rad(5.0)))
    with pytest.raises(Refused, match="range"):
        course(replace(plan, limits=tight))


def test_modes_that_do_not_exist_are_refused(make_plan: MakePlan) -> None:
    with pytest.raises(Refused, match="passive, assistive, transparent, resistive"):
        make_plan(mode="telepathic")


def test_patient_parameters_can_be_given(make_plan: MakePlan, course: Any) -> None:
    stiff = VirtualPatient(stiffness_nm_rad=0.3)
    assert course(make_plan(), patient=stiff).rmse_deg(0) > course(make_plan()).rmse_deg(0)
    assert virtual_patient("healthy").stiffness_nm_rad == 0.04
