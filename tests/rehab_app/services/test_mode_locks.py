"""What a page shows of locks agrees with what therapy refuses, for every template, mode and day."""

from __future__ import annotations

from datetime import date, timedelta

import pytest

from rehab_app.access import Account
from rehab_app.bootstrap import open_clinic
from rehab_app.errors import Refused
from rehab_app.services.diagnosis import locks_of, precautions
from rehab_app.services.diagnosis_templates import TEMPLATES
from rehab_app.services.mode_locks import mode_locks
from rehab_app.web.pages import patient_words
from sessions.catalogue import MAS_GRADES, ClinicalRecord

ANNA = Account("anna", "therapist", "1")
BERT = Account("bert", "assistant", "2")
EVENT = date(2026, 1, 5)


@pytest.mark.parametrize("beside", [{}, {"rheumatoid": True}, {"crps": True}])
@pytest.mark.parametrize("chosen", TEMPLATES, ids=lambda one: one.key)
@pytest.mark.parametrize("dated", [True, False])
def test_locked_is_what_therapy_refuses(chosen, dated, beside):
    event = EVENT.isoformat() if dated else ""
    record = ClinicalRecord(patient="P-0001", diagnosis=chosen.key, event_date=event, by="anna", **beside)
    for days in (0, 1, 3, 5, 7, 20, 21, 41, 42, 55, 56, 400):
        today = EVENT + timedelta(days=days)
        shown = mode_locks(record, (), today)
        assert {one.mode for one in shown if one.locked} == set(locks_of(record, (), today))
        for one in shown:
            if one.opens_on:
                assert one.locked == (today.isoformat() < one.opens_on)
            assert one.by_act_only <= one.locked


@pytest.fixture
def clinic(tmp_path):
    with open_clinic(tmp_path / "clinic") as opened:
        opened.patients.add(ANNA, given_name="Ada", family_name="L", birth_date="1950-12-31", side="left")
        yield opened


def state(clinic, since=None, **values):
    record = ClinicalRecord(patient="P-0001", by="?", **({"diagnosis": "crps"} | values))
    return clinic.clinical.state(ANNA, record, since=since)


def test_an_unlock_shows_who_and_why_and_is_taken_back(clinic):
    assert clinic.clinical.mode_locks("P-0001") == ()
    state(clinic)
    clinic.clinical.unlock(ANNA, "P-0001", "passive", "cold hand")
    shown = {one.mode: one for one in clinic.clinical.mode_locks("P-0001")}
    assert (shown["passive"].locked, shown["passive"].unlock.reason) == (False, "cold hand")
    assert shown["resistive"].locked
    clinic.clinical.lock(BERT, "P-0001", "passive")
    assert all(one.locked for one in clinic.clinical.mode_locks("P-0001"))


def test_the_later_of_two_who_state_a_record_is_told(clinic):
    first = state(clinic, since=0)
    with pytest.raises(Refused, match="stated anew by anna"):
        state(clinic, since=0, diagnosis="burn")
    second = state(clinic, since=first.id, diagnosis="burn")
    assert [one.id for one in clinic.clinical.records("P-0001")] == [second.id, first.id]
    assert state(clinic).diagnosis == "crps"


def test_the_pages_have_a_word_for_every_diagnosis_event_and_reason():
    assert {one.key for one in TEMPLATES} == set(patient_words.DIAGNOSES)
    assert {one.event for one in TEMPLATES} == set(patient_words.EVENTS)
    assert {lock.why for one in TEMPLATES for lock in one.locks} == set(patient_words.REASONS)
    assert MAS_GRADES[0] == ""


def test_the_pages_know_every_sentence_of_a_precaution():
    worst = ClinicalRecord(
        patient="P-0001", diagnosis="stroke", insensate=True, hyperextension_allowed=True, by="anna"
    )
    assert precautions(worst).notes == patient_words.NOTES


def test_of_two_who_state_at_once_one_is_told(clinic):
    from concurrent.futures import ThreadPoolExecutor

    def once(diagnosis):
        try:
            return state(clinic, since=0, diagnosis=diagnosis).id
        except Refused:
            return None

    with ThreadPoolExecutor(4) as threads:
        told = list(threads.map(once, ["crps", "burn", "stroke", "fracture"]))
    assert len([one for one in told if one]) == 1
    assert len(clinic.clinical.records("P-0001")) == 1
