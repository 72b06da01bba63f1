"""A few of many for a list: whom somebody works with, takes by filter and words; on both engines."""

from __future__ import annotations

import itertools

import pytest

from sessions.catalogue import Catalogue, Patient, PatientEntry, TakeFilter, TakeWord, TherapySession
from tests.contracts.test_catalogue import catalogue, sha, take, url

__all__ = ["catalogue", "url"]


def people(catalogue: Catalogue, many: int) -> list[str]:
    return [
        catalogue.add_patient(Patient(given_name="Eva", family_name=f"Lind {number}", side="left")).id
        for number in range(many)
    ]


def session(catalogue: Catalogue, patient: str, word: str, started_utc_ns: int) -> None:
    catalogue.add_session(
        TherapySession(
            patient=patient,
            sha256=sha(word),
            path=f"sessions/{word}.mcap",
            mode="passive",
            started_utc_ns=started_utc_ns,
        )
    )


def test_few_patients_come_all_and_by_pseudonym(catalogue: Catalogue) -> None:
    made = people(catalogue, 4)
    rows, total = catalogue.recent_patients(4)
    assert [one.id for one in rows] == made
    assert total == 4


def test_of_many_those_whom_somebody_works_with_come_first(catalogue: Catalogue) -> None:
    made = people(catalogue, 30)
    later_ns = 1_790_000_000_000_000_000 + 10**12
    session(catalogue, made[3], "old", later_ns)
    session(catalogue, made[5], "new", later_ns + 1)
    catalogue.add_entry(PatientEntry(patient=made[7], kind="note", content="x", by="anna"))
    catalogue.add_entry(PatientEntry(patient=made[9], kind="plan", content="{}", by="anna"))
    gone = catalogue.patient(made[29])
    catalogue.change_patient(Patient(id=gone.id, side="left", archived=True, version=gone.version))
    session(catalogue, made[3], "older", later_ns - 1)
    assert catalogue.lately_treated() == (made[5], made[3])
    rows, total = catalogue.recent_patients(5)
    assert [one.id for one in rows] == [made[5], made[3], made[9], made[28], made[27]]
    assert total == 29


def test_takes_are_found_by_what_they_are(catalogue: Catalogue) -> None:
    (eva,) = people(catalogue, 1)
    mine = catalogue.add_take(take("a", exercise="fist", side="left", subject_id=eva))
    other = catalogue.add_take(take("b", exercise="pinch", side="right", subject_id="T-1", parent=mine.id))
    catalogue.approve(other.id, "anna")
    fits = {
        TakeFilter(): [other, mine],
        TakeFilter(exercise="fist"): [mine],
        TakeFilter(side="right"): [other],
        TakeFilter(subject=eva): [mine],
        TakeFilter(parent=mine.id): [other],
        TakeFilter(approved=True): [other],
        TakeFilter(approved=False): [mine],
        TakeFilter(words=(TakeWord("lind"),)): [mine],
        TakeFilter(words=(TakeWord(mine.id[:6]),)): [mine],
        TakeFilter(words=(TakeWord("t-1"),)): [other],
        TakeFilter(words=(TakeWord("faust", exercises=("fist",)),)): [mine],
        TakeFilter(words=(TakeWord("destra", sides=("right",)), TakeWord("lind"))): [],
        TakeFilter(exercise="\x00"): [],
        TakeFilter(words=(TakeWord("%"),)): [],
    }
    for wanted, found in fits.items():
        assert catalogue.find_takes(wanted, 0, 10) == (tuple(found), len(found)), wanted
    assert catalogue.find_takes(TakeFilter(), 1, 1) == ((mine,), 2)
    assert catalogue.take_counts() == {"pinch": 1, "fist": 1}
    assert catalogue.take_counts(approved=True) == {"pinch": 1}
    assert [one.id for one in catalogue.demonstrators(5)] == [eva]


def test_a_withdrawn_take_is_not_approved(catalogue: Catalogue) -> None:
    made = catalogue.add_take(take("a"))
    catalogue.approve(made.id, "anna")
    catalogue.withdraw(made.id, "anna")
    assert catalogue.find_takes(TakeFilter(approved=True), 0, 10) == ((), 0)
    assert catalogue.approvals((made.id,)) == {}
    catalogue.approve(made.id, "bert")
    assert catalogue.find_takes(TakeFilter(approved=True), 0, 10)[1] == 1
    assert catalogue.approvals((made.id,))[made.id].by == "bert"
    assert catalogue.approvals(()) == {}


def test_an_archived_patients_name_finds_no_take(catalogue: Catalogue) -> None:
    (eva,) = people(catalogue, 1)
    made = catalogue.add_take(take("a", subject_id=eva))
    catalogue.change_patient(Patient(id=eva, family_name="Lind", side="left", archived=True))
    assert catalogue.find_takes(TakeFilter(words=(TakeWord("lind"),)), 0, 10) == ((), 0)
    assert catalogue.find_takes(TakeFilter(words=(TakeWord(eva.casefold()),)), 0, 10) == ((made,), 1)
    assert catalogue.demonstrators(5) == ()
    assert catalogue.patients_named((eva,)) == ()


@pytest.mark.parametrize("many", [0, 1, 501, 1003])
def test_any_number_of_patients_is_looked_up_by_name(catalogue: Catalogue, many: int) -> None:
    made = people(catalogue, 1)
    asked = (*made, *(f"P-9{number:05d}" for number in itertools.islice(itertools.count(), many)))
    assert [one.id for one in catalogue.patients_named(asked)] == made
