"""The journal: who wrote what when; corrections name the old entry and take nothing away."""

from __future__ import annotations

import pytest

from rehab_app.access import Account
from rehab_app.bootstrap import open_clinic
from rehab_app.errors import Refused
from rehab_app.services.journal import AdverseEvent, CheckIn, Journal, Note, PainReport

ANNA = Account("anna", "therapist", "1")
BERT = Account("bert", "assistant", "2")
WATCH = Account("wim", "auditor", "3")
SELF = Account("pat", "patient", "4")
NOON_NS = 1_795_000_000_000_000_000


@pytest.fixture
def clinic(tmp_path):
    with open_clinic(tmp_path / "clinic") as opened:
        for given in ("Ada", "Bea"):
            opened.patients.add(ANNA, given_name=given, family_name="L", birth_date="1950-12-31", side="left")
        yield opened


def test_entries_carry_author_time_and_come_back_as_they_were_written(clinic):
    held = clinic.journal
    event = AdverseEvent("mild", "redness\r\nat the strap", "loosened")
    answers = CheckIn(2, "red", "some", "2026-01-31", "no thumb", "tired")
    held.note(BERT, "P-0001", " warm hand ")
    held.pain(SELF, "P-0001", PainReport(None))
    held.adverse_event(ANNA, "P-0001", event)
    held.check_in(BERT, "P-0001", answers)
    written = held.entries("P-0001")
    assert [one.kind for one in written] == ["check-in", "adverse-event", "pain", "note"]
    assert [one.by for one in written] == ["bert", "anna", "pat", "bert"]
    assert written[0].what == answers == held.latest_check_in("P-0001").what
    assert written[1].what == AdverseEvent("mild", "redness\nat the strap", "loosened")
    assert written[3].what == Note("warm hand")
    assert all(one.created_utc_ns > 0 and not one.corrected_by for one in written)
    assert held.entries("P-0002") == ()
    assert held.latest_check_in("P-0002") is None
    details = [row.detail + row.subject for row in clinic.catalogue.audit()]
    assert not any("warm" in text or "redness" in text for text in details)


def test_a_correction_names_the_old_entry_and_both_stay(clinic):
    held = clinic.journal
    old = held.pain(ANNA, "P-0001", PainReport(7))
    new = held.pain(BERT, "P-0001", PainReport(2), corrects=old.id)
    assert [(one.id, one.corrects, one.corrected_by) for one in held.entries("P-0001")] == [
        (new.id, old.id, 0),
        (old.id, 0, new.id),
    ]
    assert [point.score for point in held.pain_course("P-0001")] == [2]
    with pytest.raises(Refused, match=f"corrected already by entry {new.id}"):
        held.pain(ANNA, "P-0001", PainReport(3), corrects=old.id)


def test_only_an_entry_of_this_patient_and_kind_can_be_corrected(clinic):
    held = clinic.journal
    other = held.note(ANNA, "P-0002", "hers")
    mine = held.note(ANNA, "P-0001", "mine")
    for patient, wrong in (("P-0001", other.id), ("P-0001", 999)):
        with pytest.raises(Refused, match="unknown"):
            held.note(ANNA, patient, "x", corrects=wrong)
    with pytest.raises(Refused, match="unknown"):
        held.pain(ANNA, "P-0001", PainReport(1), corrects=mine.id)
    assert len(held.entries("P-0001")) == 1


def test_roles(clinic):
    held = clinic.journal
    with pytest.raises(Refused, match="may not note"):
        held.note(WATCH, "P-0001", "x")
    with pytest.raises(Refused, match="may not note"):
        held.adverse_event(SELF, "P-0001", AdverseEvent("mild", "a", "b"))
    with pytest.raises(Refused, match="may not note"):
        held.check_in(SELF, "P-0001", CheckIn())
    pain = held.pain(SELF, "P-0001", PainReport(4))
    with pytest.raises(Refused, match="may not note"):
        held.pain(SELF, "P-0001", PainReport(0), corrects=pain.id)


@pytest.mark.parametrize(
    "make",
    [
        lambda: Note(""),
        lambda: Note(" \n "),
        lambda: Note("x" * 10_000),
        lambda: Note("a\x1bb"),
        lambda: PainReport(-1),
        lambda: PainReport(11),
        lambda: PainReport(1, when="yesterday"),
        lambda: PainReport(1, place="x" * 81),
        lambda: AdverseEvent("", "a", "b"),
        lambda: AdverseEvent("awful", "a", "b"),
        lambda: AdverseEvent("mild", "", "b"),
        lambda: AdverseEvent("mild", "a", " "),
        lambda: CheckIn(skin="blue"),
        lambda: CheckIn(swelling="?"),
        lambda: CheckIn(pain=12),
    ],
)
def test_what_cannot_be_meant_is_refused(make):
    with pytest.raises(Refused):
        make()


@pytest.mark.parametrize("day", ["31.1.2026", "2999-01-01", "1949-01-01"])
def test_an_injection_lies_between_birth_and_today(clinic, day):
    with pytest.raises(Refused, match="botulinum date"):
        clinic.journal.check_in(ANNA, "P-0001", CheckIn(botulinum_date=day))
    assert clinic.journal.entries("P-0001") == ()


def test_an_unknown_patient_or_session_is_refused(clinic):
    with pytest.raises(Refused, match="P-0009"):
        clinic.journal.note(ANNA, "P-0009", "x")
    with pytest.raises(Refused, match="session"):
        clinic.journal.note(ANNA, "P-0001", "x", session="00000000")


def test_the_course_of_pain_takes_scores_of_every_kind_oldest_first(clinic):
    held = Journal(clinic.catalogue, clinic.audit, lambda: NOON_NS)
    held.check_in(ANNA, "P-0001", CheckIn(pain=5))
    held.pain(ANNA, "P-0001", PainReport(3, "thumb", "after"))
    held.pain(ANNA, "P-0001", PainReport(None))
    held.check_in(ANNA, "P-0001", CheckIn())
    told = [(one.score, one.when, one.place, one.source) for one in held.pain_course("P-0001")]
    assert told == [(5, "before", "", "check-in"), (3, "after", "thumb", "pain")]


def test_a_form_sent_twice_writes_one_note_but_pain_may_be_told_again(clinic):
    held = clinic.journal
    first = held.note(ANNA, "P-0001", "same words")
    with pytest.raises(Refused, match=f"written already as entry {first.id}"):
        held.note(ANNA, "P-0001", "same words ")
    held.note(BERT, "P-0001", "same words")
    held.note(ANNA, "P-0002", "same words")
    for _ in range(2):
        held.pain(ANNA, "P-0001", PainReport(None))
    later = Journal(clinic.catalogue, clinic.audit, lambda: first.created_utc_ns + 601_000_000_000)
    later.note(ANNA, "P-0001", "same words")
    assert len(held.entries("P-0001")) == 5
