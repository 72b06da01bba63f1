"""Hazard 1: wrong patient, side or mirror. A plan is one patient's; another side is mirrored, and said."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rehab_app.access import CONSOLE
from rehab_app.bootstrap import open_clinic
from rehab_app.errors import REFUSALS, Refused
from rehab_app.services.clinic import Clinic
from rehab_app.services.order import Order
from rehab_app.services.wearer import binding
from robot_iface.build import capabilities
from robot_iface.kinematics import average_hand, forward
from robot_iface.safety import shipped_limits
from robot_iface.types import DIGITS, JOINTS

ONE = Order(repetitions=1)


@pytest.fixture(scope="module")
def clinic(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Clinic]:
    """One approved take of a right hand; A and B with right hands of different size, C with a left one."""
    with open_clinic(tmp_path_factory.mktemp("clinic")) as opened:
        recorded = opened.takes.record_virtual("open_close", "right", 3.0, 2, CONSOLE)
        opened.takes.approve(recorded.take, CONSOLE)
        for name, side, length_m in (("A", "right", 0.18), ("B", "right", 0.19), ("C", "left", 0.18)):
            opened.patients.add(
                CONSOLE,
                given_name=name,
                family_name="Test",
                birth_date="1950-12-31",
                side=side,
                hand_length_m=length_m,
            )
        yield opened


def plan(clinic: Clinic, patient_id: str | None) -> Any:
    return clinic.therapy.plan(clinic.takes.list()[0].id, ONE, actor=CONSOLE, patient_id=patient_id)


def refused(clinic: Clinic, prepared: Any, words: str, present: str | None = None) -> None:
    before = len(clinic.sessions.list())
    with pytest.raises(REFUSALS, match=words):
        clinic.therapy.rehearse_and_play(prepared, actor=CONSOLE, present=present)
    assert len(clinic.sessions.list()) == before


def test_an_unknown_patient_gets_no_plan(clinic: Clinic) -> None:
    with pytest.raises(Refused, match="P-9999"):
        plan(clinic, "P-9999")


@pytest.mark.parametrize("other", ["P-0002", "P-0003", ""])
def test_a_plan_cannot_be_run_for_somebody_else(clinic: Clinic, other: str) -> None:
    refused(clinic, replace(plan(clinic, "P-0001"), patient_id=other), "another patient")


def test_a_demonstration_cannot_be_run_as_a_patients_session(clinic: Clinic) -> None:
    refused(clinic, replace(plan(clinic, None), patient_id="P-0001"), "another patient")


def test_parts_of_another_patients_plan_are_found(clinic: Clinic) -> None:
    mine, theirs = plan(clinic, "P-0001"), plan(clinic, "P-0002")
    mixed = replace(mine.plan, twin=theirs.plan.twin, path=theirs.plan.path)
    refused(clinic, replace(mine, plan=mixed), "another patient")
    assert len({plan(clinic, one).binding for one in (None, "P-0001", "P-0002", "P-0003")}) == 4


def test_whoever_is_present_must_be_the_patient_of_the_plan(clinic: Clinic) -> None:
    refused(clinic, plan(clinic, "P-0001"), "made for P-0002, who is present", present="P-0002")
    refused(clinic, plan(clinic, None), "made for no patient", present="P-0002")


def test_a_side_that_was_corrected_after_planning_is_found(clinic: Clinic) -> None:
    prepared = plan(clinic, "P-0002")
    kept = clinic.catalogue.patient("P-0002")
    clinic.catalogue.change_patient(replace(kept, side="left"))
    try:
        refused(clinic, prepared, "on record")
    finally:
        clinic.catalogue.change_patient(replace(kept, version=kept.version + 1))


def test_limits_of_the_other_hand_are_not_used(clinic: Clinic, tmp_path: Path) -> None:
    from rehab_app.services.audit import Audit
    from rehab_app.services.patient_limits import PatientLimits

    device = capabilities("exoskeleton")
    other = replace(clinic.catalogue.patient("P-0002"), side="left")
    measured = shipped_limits(device.joint_names, device.q_min_rad + 0.2, device.q_max_rad - 0.2)
    limits = PatientLimits(clinic.catalogue, Audit(clinic.catalogue))
    limits.keep(CONSOLE, other, device, measured, 0.0)
    with pytest.raises(Refused, match="of the left hand"):
        plan(clinic, "P-0002")


def test_a_take_of_the_other_side_is_mirrored_once_and_said(clinic: Clinic) -> None:
    right, left = plan(clinic, "P-0001"), plan(clinic, "P-0003")
    assert (right.plan.side, left.plan.side) == ("right", "left")
    assert left.plan.twin.side == left.geometry.side == "left"
    assert any("mirrored for a left hand" in note for note in left.notes)
    assert not any("mirrored" in note for note in right.notes)
    np.testing.assert_allclose(left.plan.path.q_rad, right.plan.path.q_rad, atol=1e-12)


def test_mirrored_angles_are_the_mirror_image_in_space() -> None:
    """The law behind it: equal angles on both sides place every landmark at mirrored points."""
    angles = np.random.default_rng(4).uniform(-0.2, 1.0, (50, len(JOINTS)))
    points = {side: forward(average_hand(0.18, side), angles).landmarks_m for side in ("left", "right")}
    np.testing.assert_allclose(points["left"], points["right"] * [1.0, -1.0, 1.0], atol=1e-12)
    assert points["left"].shape[1] >= 4 * len(DIGITS)


def test_the_binding_knows_everything_that_belongs_to_a_person(clinic: Clinic) -> None:
    made = plan(clinic, "P-0001").plan
    own = binding("P-0001", made)
    twin = made.twin
    changed = (
        replace(made, twin=replace(twin, side="left")),
        replace(made, twin=replace(twin, hand_length_m=0.2)),
        replace(made, twin=replace(twin, bones_m=((0.04,) * 3,) * 5)),
        replace(made, wrist_rad=0.3),
        replace(made, device="other"),
        replace(made, limits=replace(made.limits, tau_interaction_nm=2.0 * made.limits.tau_interaction_nm)),
    )
    assert own not in {binding("P-0001", one) for one in changed}
    assert own != binding("P-0002", made)
