"""Clinical records: who may state and unlock them, and what they refuse."""

from __future__ import annotations

from dataclasses import replace

import pytest

from rehab_app.access import CONSOLE, Account
from rehab_app.bootstrap import open_clinic
from rehab_app.errors import Refused
from rehab_app.services.clinical import bones_of
from sessions.catalogue import ClinicalRecord

THERAPIST = Account("anna", "therapist", "1")
ASSISTANT = Account("bert", "assistant", "2")
BONES = "[[0.046, 0.036, 0.029], [0.045, 0.026, 0.018], [0.049, 0.031, 0.02], [0.045, 0.03, 0.02], " + (
    "[0.037, 0.021, 0.017]]"
)


@pytest.fixture
def clinic(tmp_path):
    with open_clinic(tmp_path / "clinic") as opened:
        opened.patients.add(
            CONSOLE, given_name="Ada", family_name="Lovelace", birth_date="1950-12-31", side="left"
        )
        yield opened


def record(**changes):
    plain = ClinicalRecord(patient="P-0001", diagnosis="fracture", event_date="2026-01-02", by="x")
    return replace(plain, **changes)


def test_nothing_is_stated_at_first(clinic):
    assert clinic.clinical.record("P-0001") is None
    assert clinic.clinical.locks("P-0001") == {}
    assert clinic.clinical.check_mode("P-0001", "resistive") == ()
    with pytest.raises(Refused, match="P-9999"):
        clinic.clinical.record("P-9999")


def test_a_record_is_a_version_with_its_author_and_no_name_in_the_audit(clinic):
    clinic.clinical.state(THERAPIST, record())
    kept = clinic.clinical.state(THERAPIST, record(diagnosis="stroke", mas="2", bones_m=BONES))
    assert clinic.clinical.record("P-0001") == kept
    assert kept.by == "anna"
    assert bones_of(kept)[1] == (0.045, 0.026, 0.018)
    assert len(clinic.catalogue.clinical_records("P-0001")) == 2
    row = clinic.catalogue.audit()[0]
    assert (row.actor, row.verb, row.subject) == ("anna", "state clinical record", "P-0001")


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"patient": "P-9999"}, "P-9999"),
        ({"diagnosis": "bad luck"}, "one of none"),
        ({"event_date": "2190-01-01"}, "today or before"),
        ({"event_date": "1949-01-01"}, "birth"),
        ({"bones_m": "[[1, 2]]"}, "5 digits"),
        ({"bones_m": BONES.replace("0.046", "0.9")}, "8 to 80 mm"),
        ({"bones_m": BONES.replace("0.046", "NaN")}, "8 to 80 mm"),
        ({"bones_m": "hello"}, "5 digits"),
    ],
)
def test_a_record_that_cannot_be_is_refused_and_not_kept(clinic, changes, words):
    with pytest.raises(Refused, match=words):
        clinic.clinical.state(THERAPIST, record(**changes))
    assert clinic.clinical.record("P-0001") is None


def test_an_assistant_may_neither_state_nor_unlock_but_may_lock(clinic):
    with pytest.raises(Refused, match="may not prescribe"):
        clinic.clinical.state(ASSISTANT, record())
    clinic.clinical.state(THERAPIST, record(diagnosis="crps", event_date=""))
    assert set(clinic.clinical.locks("P-0001")) == {"passive", "resistive"}
    with pytest.raises(Refused, match="may not prescribe"):
        clinic.clinical.unlock(ASSISTANT, "P-0001", "passive", "he asked for it")
    clinic.clinical.unlock(THERAPIST, "P-0001", "passive", "warm and quiet today")
    assert set(clinic.clinical.locks("P-0001")) == {"resistive"}
    (note,) = clinic.clinical.check_mode("P-0001", "passive")
    assert "anna" in note
    assert "warm and quiet" in note
    clinic.clinical.lock(ASSISTANT, "P-0001", "passive")
    assert set(clinic.clinical.locks("P-0001")) == {"passive", "resistive"}
    verbs = [(row.actor, row.verb) for row in clinic.catalogue.audit()[:2]]
    assert verbs == [("bert", "lock mode"), ("anna", "unlock mode")]


def test_another_event_locks_again(clinic):
    clinic.clinical.state(THERAPIST, record(diagnosis="crps", event_date=""))
    clinic.clinical.unlock(THERAPIST, "P-0001", "passive", "quiet")
    clinic.clinical.state(THERAPIST, record(diagnosis="crps", event_date="2026-03-01"))
    with pytest.raises(Refused, match="passive mode"):
        clinic.clinical.check_mode("P-0001", "passive")


def test_what_is_not_locked_is_not_unlocked(clinic):
    with pytest.raises(Refused, match="not locked"):
        clinic.clinical.unlock(THERAPIST, "P-0001", "passive", "why not")
    clinic.clinical.state(THERAPIST, record(diagnosis="crps"))
    for mode, reason, words in (
        ("assistive", "x", "not locked"),
        ("dance", "x", "one of passive"),
        ("passive", " ", "reason"),
        ("passive", "x" * 501, "500"),
    ):
        with pytest.raises(Refused, match=words):
            clinic.clinical.unlock(THERAPIST, "P-0001", mode, reason)
    with pytest.raises(Refused, match="not unlocked"):
        clinic.clinical.lock(THERAPIST, "P-0001", "passive")
