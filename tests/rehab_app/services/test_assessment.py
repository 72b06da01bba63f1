"""Guided assessments: the sweep measures the limits of the day, the fit check looks before a worn run."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from rehab_app.access import CONSOLE, Account
from rehab_app.bootstrap import open_clinic
from rehab_app.errors import REFUSALS, Refused
from rehab_app.services.assessed import device_ends, fit_to_json, neutral_from_json
from rehab_app.services.assessment import Assessment
from rehab_app.services.limits_json import limits_from_json
from rehab_app.services.order import Order
from rehab_app.services.sweep_postures import POSTURES, postures_of
from robot_iface.build import capabilities
from robot_iface.kinematics import average_hand
from robot_iface.motion.clearance import too_close, whole_hand
from robot_iface.safety import shipped_limits
from sessions.catalogue import ClinicalRecord
from sessions.store import SessionReader, verify

AUDITOR = Account("otto", "auditor", "3")
DEVICE = capabilities("exoskeleton")
WRIST = Order(wrist_rad=0.2)


@pytest.fixture(scope="module")
def clinic(tmp_path_factory):
    with open_clinic(tmp_path_factory.mktemp("clinic")) as opened:
        for _ in range(2):
            opened.patients.add(
                CONSOLE, given_name="Ada", family_name="L", birth_date="1950-12-31", side="left"
            )
        yield opened


@pytest.fixture(scope="module")
def measured(clinic):
    prepared = clinic.assessment.plan_range("P-0001", WRIST, actor=CONSOLE)
    return prepared, clinic.assessment.measure_limits(prepared, actor=CONSOLE, present="P-0001")


def test_a_sweep_becomes_the_limits_of_the_day(clinic, measured):
    prepared, found = measured
    limits = limits_from_json(found.kept.content)
    base = prepared.plan.limits
    assert np.all(limits.q_min_rad >= base.q_min_rad)
    assert np.all(limits.q_max_rad <= base.q_max_rad)
    for finger in ("index", "middle", "ring", "little"):
        pip = DEVICE.joint_names.index(f"{finger}_pip")
        assert np.rad2deg(limits.q_max_rad[pip] - limits.q_min_rad[pip]) > 60.0
    assert len(limits.hulls) == 4
    held = clinic.limits.show("P-0001", wrist_rad=0.2)
    assert held.measured
    assert np.array_equal(held.limits.q_max_rad, limits.q_max_rad)
    with pytest.raises(Refused, match="wrist"):
        clinic.limits.show("P-0001", wrist_rad=0.6)
    assert not clinic.limits.show("P-0002", wrist_rad=0.2).measured


def test_an_end_that_is_the_devices_is_said(measured):
    _, found = measured
    assert any("device limit" in sentence for sentence in device_ends(found.result))


def test_the_sweep_is_a_sealed_session_without_a_take(clinic, measured):
    _, found = measured
    verify(found.run.path)
    row = clinic.sessions.get(found.run.session)
    assert (row.take_id, row.patient_id) == ("", "P-0001")
    assert row.mode == found.run.mode
    with SessionReader(found.run.path) as reader:
        assert reader.header.exercise == "range of motion sweep"
        assert reader.header.subject_id == "P-0001"
        assert "Ada" not in json.dumps(reader.header.subject_hand)
    assert clinic.catalogue.prescriptions("P-0001") == ()


def test_what_is_played_keeps_to_what_was_measured(clinic, measured, take_file):
    _, found = measured
    take = clinic.takes.get(take_file).id
    prepared = clinic.therapy.plan(take, WRIST, actor=CONSOLE, patient_id="P-0001")
    limits = limits_from_json(found.kept.content)
    assert np.all(prepared.plan.path.q_rad >= limits.q_min_rad - 1e-9)
    assert np.all(prepared.plan.path.q_rad <= limits.q_max_rad + 1e-9)
    assert len(prepared.plan.limits.hulls) == 4


def test_a_fit_check_is_kept_and_the_next_is_compared_with_it(clinic):
    for _ in range(2):
        prepared = clinic.assessment.plan_fit("P-0002", actor=CONSOLE)
        checked = clinic.assessment.check_fit(prepared, actor=CONSOLE)
        assert checked.result.verdict == ""
    newest, first = clinic.catalogue.fit_checks("P-0002", "exoskeleton")
    assert (newest.side, newest.by, newest.session) == ("left", "console", checked.run.session)
    neutral = neutral_from_json(first.content, DEVICE.joint_names)
    assert np.allclose(neutral, checked.result.neutral_rad, atol=np.deg2rad(2.0))
    assert json.loads(fit_to_json(checked.result)) == json.loads(newest.content)
    assert np.isnan(neutral_from_json("{}", DEVICE.joint_names)).all()


def test_a_fit_that_is_asked_for_and_not_good_stops_everything(clinic, monkeypatch):
    checked = clinic.assessment.require_fit("P-0001", Order(), actor=CONSOLE)
    bad = replace(checked, result=replace(checked.result, verdict="index_pip sticks"))
    monkeypatch.setattr(Assessment, "check_fit", lambda *_, **__: bad)
    with pytest.raises(Refused, match="index_pip sticks"):
        clinic.assessment.require_fit("P-0001", Order(), actor=CONSOLE)
    with pytest.raises(Refused, match="--patient"):
        clinic.assessment.require_fit(None, Order(), actor=CONSOLE)


def test_who_may_not_or_is_locked_gets_no_sweep(clinic):
    with pytest.raises(Refused, match="may not play"):
        clinic.assessment.plan_range("P-0002", actor=AUDITOR)
    with pytest.raises(Refused, match="P-9999"):
        clinic.assessment.plan_fit("P-9999", actor=CONSOLE)
    record = ClinicalRecord(patient="P-0002", diagnosis="crps", by="x")
    clinic.clinical.state(CONSOLE, record)
    with pytest.raises(Refused, match="passive mode"):
        clinic.assessment.plan_range("P-0002", actor=CONSOLE)
    clinic.assessment.plan_fit("P-0002", actor=CONSOLE)  # small and slow: any open mode will do
    clinic.clinical.state(CONSOLE, replace(record, diagnosis="fracture"))
    with pytest.raises(Refused, match="passive mode"):
        clinic.assessment.plan_fit("P-0002", actor=CONSOLE)


def test_a_sweep_is_one_patients(clinic):
    prepared = clinic.assessment.plan_fit("P-0001", actor=CONSOLE)
    for wrong, present in ((replace(prepared, patient_id="P-0002"), None), (prepared, "P-0002")):
        with pytest.raises(REFUSALS, match="made for"):
            clinic.assessment.check_fit(wrong, actor=CONSOLE, present=present)


@pytest.mark.parametrize("length_m", [0.16, 0.189, 0.22])
def test_no_posture_of_the_sweep_closes_over_the_thumb_or_into_the_palm(length_m):
    limits = shipped_limits(DEVICE.joint_names, DEVICE.q_min_rad, DEVICE.q_max_rad)
    names, goals = postures_of("range", DEVICE.joint_names, limits)
    assert names == tuple(POSTURES)
    assert np.all((goals >= limits.q_min_rad) & (goals <= limits.q_max_rad))
    rest = limits.q_min_rad + 0.3 * (limits.q_max_rad - limits.q_min_rad)
    for goal in goals:
        way = rest + np.linspace(0.0, 1.0, 80)[:, None] * (goal - rest)
        assert too_close(average_hand(length_m), whole_hand(way, DEVICE.joint_names)) is None
    assert postures_of("fit", DEVICE.joint_names, limits)[1].shape == (0, len(DEVICE.joint_names))


def test_every_driven_joint_is_shown_most_of_its_range():
    limits = shipped_limits(DEVICE.joint_names, DEVICE.q_min_rad, DEVICE.q_max_rad)
    _, goals = postures_of("range", DEVICE.joint_names, limits)
    assert np.all(np.ptp(goals, axis=0) >= 0.88 * (limits.q_max_rad - limits.q_min_rad))
