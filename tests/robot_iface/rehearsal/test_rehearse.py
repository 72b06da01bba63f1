"""A rehearsal certifies one plan, names the first violation, and cannot be altered."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from robot_iface.build import open_rig
from robot_iface.errors import Refused
from robot_iface.rehearsal import rehearse
from robot_iface.runtime import ScriptedInbox, Surroundings, run
from robot_iface.sim import DRIVEN
from robot_iface.types import Certificate, PatientTwin, Plan

MakePlan = Callable[..., Plan]


class NeverPressed:
    def pressed(self) -> bool:
        return False


def start(plan: Plan, certificate: Certificate) -> list[Any]:
    messages: list[Any] = []
    run(plan, certificate, open_rig(plan), Surroundings(NeverPressed(), messages.append, ScriptedInbox()))
    return messages


@pytest.fixture
def short(fist: Any) -> Any:
    return fist(1.0, 6.0, 20.0)


def test_an_accepted_plan_runs(make_plan: MakePlan, short: Any) -> None:
    plan = make_plan(path=short)
    certificate = rehearse(plan)
    assert certificate.accepted
    assert "within every bound" in certificate.summary
    assert certificate.simulated_s > 1.0
    assert len(certificate.peak_interaction_nm) == len(DRIVEN)
    assert max(certificate.peak_interaction_nm) > 0.0
    assert start(plan, certificate)[-1].completed


def test_rehearsing_twice_gives_the_same_certificate(make_plan: MakePlan, short: Any) -> None:
    plan = make_plan(path=short)
    assert rehearse(plan) == rehearse(plan)


@pytest.mark.parametrize(
    ("part", "alter"),
    [
        ("path", lambda plan: replace(plan, path=replace(plan.path, q_rad=plan.path.q_rad + 1e-9))),
        ("prescription", lambda plan: replace(plan, prescription=replace(plan.prescription, speed=0.4))),
        ("limits", lambda plan: replace(plan, limits=replace(plan.limits, power_w=2.1))),
        ("twin", lambda plan: replace(plan, twin=PatientTwin("weak"))),
        ("device", lambda plan: replace(plan, device="dlr-hit-ii")),
        ("software version", lambda plan: replace(plan, software_version="0.1")),
    ],
)
def test_a_certificate_for_another_plan_is_refused_and_the_difference_named(
    make_plan: MakePlan, short: Any, part: str, alter: Callable[[Plan], Plan]
) -> None:
    plan = make_plan(path=short)
    certificate = _certified(plan)
    other = alter(plan)
    rig = open_rig(plan)
    with pytest.raises(Refused, match=f"a different {part},"):
        run(other, certificate, rig, Surroundings(NeverPressed(), lambda message: None, ScriptedInbox()))
    assert rig.robot.read().seq == 0


def _certified(plan: Plan) -> Certificate:
    """A genuine certificate without the wait for a dry run."""
    from robot_iface.runtime import plan_parts, seal

    return seal(Certificate("", True, "within every bound", (0.0,) * 12, 1.0, plan_parts(plan)))


@pytest.mark.parametrize(
    "alteration",
    [{"accepted": False}, {"summary": "fine"}, {"simulated_s": 9.0}, {"digest": "0" * 64}, {"parts": ()}],
)
def test_an_altered_certificate_is_refused(make_plan: MakePlan, short: Any, alteration: Any) -> None:
    plan = make_plan(path=short)
    with pytest.raises(Refused, match="altered"):
        start(plan, replace(_certified(plan), **alteration))


def test_seed_and_pace_need_no_new_rehearsal(make_plan: MakePlan, short: Any) -> None:
    plan = make_plan(path=short)
    assert start(replace(plan, seed=99), _certified(plan))[-1].completed


def test_a_path_that_is_too_fast_is_not_accepted_and_the_place_is_named(
    make_plan: MakePlan, fist: Any
) -> None:
    plan = make_plan(path=fist(1.0, 40.0))
    certificate = rehearse(plan)
    assert not certificate.accepted
    assert "speed" in certificate.summary
    assert "bound 60.0" in certificate.summary
    assert any(name in certificate.summary for name in DRIVEN)
    with pytest.raises(Refused, match="not accepted"):
        start(plan, certificate)


def test_a_path_out_of_range_is_not_accepted(make_plan: MakePlan, fist: Any) -> None:
    certificate = rehearse(make_plan(path=fist(10.0, 30.0, -6.0)))
    assert not certificate.accepted
    assert "angle" in certificate.summary


def test_a_stretch_that_is_held_too_long_is_not_accepted(make_plan: MakePlan, fist: Any) -> None:
    plan = make_plan("mas3", path=fist(4.0, 30.0, 2.0), hold_s=6.0)
    opening = replace(plan.path, q_rad=np.ascontiguousarray(np.deg2rad(36.0) - plan.path.q_rad))
    half = opening.t_s <= 2.0
    opening = replace(opening, t_s=opening.t_s[half] * 3, q_rad=opening.q_rad[half])
    certificate = rehearse(replace(plan, path=opening))
    assert not certificate.accepted
    assert "held-stretch" in certificate.summary


def test_a_spastic_hand_that_opens_in_part_is_accepted_and_said_to(make_plan: MakePlan, fist: Any) -> None:
    certificate = rehearse(make_plan("mas3", path=fist(6.0, 40.0, 4.0)))
    assert certificate.accepted
    assert "only in part" in certificate.summary


def test_another_robot_is_refused_with_those_that_exist(make_plan: MakePlan) -> None:
    with pytest.raises(Refused, match="exoskeleton"):
        open_rig(replace(make_plan(), device="glove"))
