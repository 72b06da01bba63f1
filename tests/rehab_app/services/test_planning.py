"""A plan respects the patient's record, limits and memory; it is that patient's and of today."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from rehab_app.access import CONSOLE, Account
from rehab_app.bootstrap import open_clinic
from rehab_app.errors import REFUSALS, Refused
from rehab_app.services import planning, wearer
from rehab_app.services.limits_json import limits_from_json
from rehab_app.services.order import Order
from rehab_app.services.planning import assistance_from_json, assistance_to_json
from rehab_app.services.wearer import check_device
from robot_iface.build import capabilities
from sessions.catalogue import AssistanceMemory, ClinicalRecord, Patient, TherapySession

ASSISTANT = Account("bert", "assistant", "2")
ONE = Order(repetitions=1)
ROWS = ((1.0, 1.1, 1.2, 1.3, 1.4), (0.5, 0.6, 0.7, 0.8, 0.9))


@pytest.fixture
def clinic(tmp_path, take_file):
    with open_clinic(tmp_path / "clinic") as opened:
        row = opened.takes.get(take_file)
        opened.takes.approve(row.id, CONSOLE)
        opened.patients.add(
            CONSOLE, given_name="Ada", family_name="Lovelace", birth_date="1950-12-31", side="right"
        )
        yield opened


def plan(clinic, order=ONE, patient_id="P-0001", actor=CONSOLE):
    return clinic.therapy.plan(clinic.takes.list()[0].id, order, actor=actor, patient_id=patient_id)


def state(clinic, **changes):
    record = replace(ClinicalRecord(patient="P-0001", diagnosis="none", by="x"), **changes)
    return clinic.clinical.state(CONSOLE, record)


def test_where_the_limits_come_from_is_said(clinic):
    for patient_id in (None, "P-0001"):
        assert any("shipped defaults" in note for note in plan(clinic, patient_id=patient_id).notes)


def test_two_identifiers_are_for_the_screen_only(clinic):
    prepared = plan(clinic)
    assert prepared.identity == "Ada Lovelace, born 1950-12-31, right hand (P-0001)"
    assert not any("Lovelace" in note for note in prepared.notes)
    assert plan(clinic, patient_id=None).identity == ""


def test_the_twin_is_the_patient_of_the_record(clinic):
    assert plan(clinic).plan.twin.kind == "healthy"
    bones = [[0.046, 0.036, 0.029]] + [[0.045, 0.026, 0.018]] * 4
    state(clinic, diagnosis="stroke", mas="4", event_date="2026-01-01", bones_m=json.dumps(bones))
    prepared = plan(clinic)
    twin, limits = prepared.plan.twin, prepared.plan.limits
    assert (twin.kind, twin.side, twin.stiffness_nm_rad) == ("mas3", "right", 0.9)
    assert twin.bones_m[0] == (0.046, 0.036, 0.029)
    assert prepared.geometry.bones_m[1, 0] == 0.045
    assert np.allclose(limits.extension_speed_rad_s, np.deg2rad(15.0))


def test_a_virtual_patient_that_is_asked_for_never_loosens_the_record(clinic):
    state(clinic, diagnosis="stroke", mas="3", event_date="2026-01-01")
    prepared = plan(clinic, replace(ONE, twin="healthy"))
    assert (prepared.plan.twin.kind, prepared.plan.twin.stiffness_nm_rad) == ("healthy", 0.0)
    assert np.allclose(prepared.plan.limits.extension_speed_rad_s, np.deg2rad(15.0))
    stiff = plan(clinic, replace(ONE, twin="mas2"), patient_id=None)
    assert np.allclose(stiff.plan.limits.extension_speed_rad_s, np.deg2rad(15.0))


def test_skin_that_does_not_feel_halves_torque_and_asks_for_a_look(clinic):
    before = plan(clinic).plan
    state(clinic, insensate=True)
    prepared = plan(clinic)
    assert np.allclose(prepared.plan.limits.tau_interaction_nm, 0.5 * before.limits.tau_interaction_nm)
    assert (before.prescription.skin_check_s, prepared.plan.prescription.skin_check_s) == (0.0, 600.0)
    assert any("skin" in note for note in prepared.notes)


def test_a_locked_mode_is_refused_until_a_therapist_unlocks_it(clinic):
    state(clinic, diagnosis="crps")
    with pytest.raises(Refused, match="passive mode"):
        plan(clinic)
    plan(clinic, replace(ONE, mode="assistive"))
    clinic.clinical.unlock(CONSOLE, "P-0001", "passive", "quiet today")
    assert any("unlocked by console: quiet today" in note for note in plan(clinic).notes)


def test_a_young_repair_needs_a_range_of_its_own(clinic):
    import datetime

    recent = (datetime.datetime.now(datetime.UTC).date() - datetime.timedelta(days=10)).isoformat()
    state(clinic, diagnosis="flexor-tendon-repair", event_date=recent)
    with pytest.raises(Refused, match="limits range P-0001"):
        plan(clinic)
    clinic.limits.set_range(ASSISTANT, "P-0001", "index_pip", 0.0, np.deg2rad(40.0))
    prepared = plan(clinic)
    pip = prepared.plan.joint_names.index("index_pip")
    assert prepared.plan.path.q_rad[:, pip].max() < np.deg2rad(40.0)


def test_every_word_of_an_order_reaches_the_prescription(clinic):
    order = Order(
        mode="resistive",
        repetitions=4,
        speed=0.4,
        space="fingertip",
        warm_up=2,
        minutes=5.0,
        resistance=0.6,
        hold_s=2.0,
        wrist_rad=0.2,
        stiffness_multiple=2.0,
        seed=3,
    )
    made = plan(clinic, order).plan
    asked = made.prescription
    assert (asked.mode, asked.space, asked.warm_up_repetitions, asked.minutes) == (
        "resistive",
        "fingertip",
        2,
        5.0,
    )
    assert (asked.resistance, asked.hold_s, asked.stiffness_multiple) == (0.6, 2.0, 2.0)
    assert (asked.speed, asked.repetitions, made.wrist_rad, made.seed) == (0.4, 4, 0.2, 3)


def remember(clinic, patient_id="P-0001", content=None):
    run = clinic.catalogue.add_session(
        TherapySession(
            patient=patient_id, sha256="c" * 64, path="sessions/x.mcap", mode="assistive", started_utc_ns=1
        )
    )
    clinic.catalogue.add_assistance(
        AssistanceMemory(
            patient=patient_id,
            exercise=clinic.takes.list()[0].exercise,
            device="exoskeleton",
            content=assistance_to_json(ROWS) if content is None else content,
            session=run.id,
        )
    )
    return run.id


def test_assistance_goes_on_where_the_last_session_ended(clinic):
    assistive = replace(ONE, mode="assistive")
    assert plan(clinic, assistive).plan.prescription.assistance == ()
    session = remember(clinic)
    prepared = plan(clinic, assistive)
    assert prepared.plan.prescription.assistance == ROWS
    assert any(session in note for note in prepared.notes)
    for other in (ONE, replace(assistive, stiffness_multiple=2.0)):
        assert plan(clinic, other).plan.prescription.assistance == ()
    assert plan(clinic, assistive, patient_id=None).plan.prescription.assistance == ()


@pytest.mark.parametrize("text", ["", "[]", "[[1],[2]]", '"x"', "[[1,2,3,4,null],[1,2,3,4,5]]", "5"])
def test_memory_that_makes_no_sense_is_forgotten(clinic, text):
    remember(clinic, content=text)
    assert plan(clinic, replace(ONE, mode="assistive")).plan.prescription.assistance == ()


def test_memory_is_kept_within_what_may_be_prescribed():
    rows = assistance_from_json("[[0.0, 9.0, 1, 1, 1], [1, 1, 1, 1, 1]]")
    assert rows[0][:2] == (0.1, 4.0)
    assert assistance_from_json(assistance_to_json(ROWS)) == ROWS


REAL = replace(capabilities("exoskeleton"), name="glove", simulated=False)
ADA = Patient(id="P-0001", given_name="Ada", family_name="L", birth_date="1950-12-31", side="right")
READY = Order(device="ros2:glove", realtime=True, confirmed_device="ros2:glove")


@pytest.mark.parametrize(
    ("order", "patient", "words"),
    [
        (replace(READY, confirmed_device=""), ADA, "--confirm-device ros2:glove"),
        (replace(READY, confirmed_device="glove"), ADA, "confirmed as 'glove'"),
        (replace(READY, realtime=False), ADA, "--realtime"),
        (READY, None, "--patient"),
        (READY, replace(ADA, birth_date=""), "birth date"),
        (READY, replace(ADA, given_name="", family_name=""), "name and birth date"),
    ],
)
def test_a_real_device_moves_only_for_a_confirmed_name_and_an_identified_patient(order, patient, words):
    with pytest.raises(Refused, match=words):
        check_device(REAL, order, patient)
    check_device(REAL, READY, ADA)
    check_device(replace(REAL, worn=False), READY, None)


def test_a_confirmation_of_a_real_device_is_not_spent_on_a_simulated_one():
    with pytest.raises(Refused, match="confirmed as real"):
        check_device(capabilities("exoskeleton"), replace(READY, device="exoskeleton"), ADA)


def test_a_patient_of_any_hand_size_may_play_a_robot_that_nobody_wears(clinic):
    small = clinic.patients.add(
        CONSOLE,
        given_name="Bo",
        family_name="Li",
        birth_date="1960-01-31",
        side="left",
        hand_length_m=0.165,
    )
    prepared = plan(clinic, replace(ONE, device="dlr-hit-ii"), patient_id=small.id)
    assert prepared.plan.twin.hand_length_m == 0.165
    clinic.therapy.check_patient(prepared, small.id)


def test_a_lock_protects_only_a_hand_that_is_in_the_robot(clinic):
    prepared = plan(clinic, replace(ONE, device="dlr-hit-ii"), patient_id="P-0001")
    state(clinic, diagnosis="crps")
    clinic.therapy.check_patient(prepared, "P-0001")


def test_a_robot_that_nobody_wears_has_its_own_limits(clinic, monkeypatch):
    bare = replace(capabilities("exoskeleton"), worn=False)
    monkeypatch.setattr(planning, "capabilities", lambda name: bare)
    state(clinic, diagnosis="crps", insensate=True)
    prepared = plan(clinic)
    assert np.array_equal(prepared.plan.limits.q_min_rad, bare.q_min_rad)
    assert np.rad2deg(prepared.plan.limits.flexion_speed_rad_s.max()) < 200.0
    assert any("not worn" in note for note in prepared.notes)


@pytest.mark.parametrize(("warm_up", "repetitions"), [(5, 3), (1, 0)])
def test_a_warm_up_that_never_ends_is_refused(warm_up, repetitions):
    with pytest.raises(REFUSALS, match="repetitions"):
        Order(warm_up=warm_up, repetitions=repetitions).prescription()
    assert Order(warm_up=3, repetitions=3).prescription().warm_up_repetitions == 3


def test_a_completed_assistive_session_is_remembered_and_its_order_kept(clinic):
    prepared = plan(clinic, replace(ONE, mode="assistive", speed=1.0))
    result = clinic.therapy.rehearse_and_play(prepared, actor=CONSOLE, present="P-0001")
    assert result.completed
    (ordered,) = clinic.catalogue.prescriptions("P-0001")
    assert json.loads(ordered.content)["mode"] == "assistive"
    assert (ordered.by, ordered.speed) == ("console", 1.0)
    limits_from_json(ordered.limits)
    exercise = clinic.takes.list()[0].exercise
    kept = clinic.catalogue.assistance("P-0001", exercise, "exoskeleton")
    again = plan(clinic, replace(ONE, mode="assistive")).plan.prescription.assistance
    assert kept is not None
    assert kept.session == result.session
    assert again == assistance_from_json(kept.content) != ()


def test_the_record_is_read_again_before_anything_moves(clinic):
    prepared = plan(clinic)
    state(clinic, diagnosis="crps")
    with pytest.raises(REFUSALS, match="passive mode"):
        clinic.therapy.rehearse_and_play(prepared, actor=CONSOLE)
    assert clinic.sessions.list() == ()
    assert (
        wearer.identity_of(Patient(id="P-2", side="left")) == "no name, birth date unknown, left hand (P-2)"
    )
