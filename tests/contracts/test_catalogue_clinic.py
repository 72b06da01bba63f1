"""What a catalogue keeps of the clinic's daily writing, over every engine it may stand on."""

from __future__ import annotations

from dataclasses import replace

import pytest

from sessions.catalogue import ENTRY_KINDS, Catalogue, Patient, PatientEntry, Setting, TherapySession
from sessions.errors import Refused
from tests.contracts.test_catalogue import catalogue, sha, url

__all__ = ["catalogue", "url"]


@pytest.fixture
def patient(catalogue: Catalogue) -> str:
    return catalogue.add_patient(Patient(side="right")).id


def entry(patient: str, **changes: str) -> PatientEntry:
    return replace(PatientEntry(patient=patient, kind="note", content="{}", by="anna"), **changes)


def test_entries_come_newest_first_and_by_kind_topic_and_session(catalogue: Catalogue, patient: str) -> None:
    session = TherapySession(
        patient=patient, sha256=sha("s"), path="sessions/s.mcap", mode="passive", started_utc_ns=1
    )
    held = catalogue.add_session(session).id
    written = [
        catalogue.add_entry(one)
        for one in (
            entry(patient, content='"first"'),
            entry(patient, kind="outcome", topic="arat"),
            entry(patient, kind="pain", session=held),
        )
    ]
    assert [one.id for one in catalogue.entries(patient, ENTRY_KINDS)] == [
        one.id for one in reversed(written)
    ]
    assert catalogue.entries(patient, ["outcome"], topic="arat") == (written[1],)
    assert catalogue.entries(patient, ["outcome"], topic="fma") == ()
    assert catalogue.entries(patient, ENTRY_KINDS, session=held) == (written[2],)
    assert len(catalogue.entries(patient, ENTRY_KINDS, limit=2)) == 2


def test_an_entry_about_nobody_is_refused(catalogue: Catalogue, patient: str) -> None:
    with pytest.raises(Refused, match="P-9999"):
        catalogue.add_entry(entry("P-9999"))
    with pytest.raises(Refused, match="unknown"):
        catalogue.add_entry(entry(patient, session="ffffffff"))
    with pytest.raises(Refused, match="kind of entry"):
        entry(patient, kind="gossip")


def test_a_change_of_a_patient_names_its_version(catalogue: Catalogue, patient: str) -> None:
    opened = catalogue.patient(patient)
    changed = catalogue.change_patient(replace(opened, impairment="stroke"))
    assert changed.version == opened.version + 1
    with pytest.raises(Refused, match="changed by somebody else"):
        catalogue.change_patient(replace(opened, impairment="burn"))
    assert catalogue.patient(patient).impairment == "stroke"


def test_the_newest_setting_counts(catalogue: Catalogue) -> None:
    assert catalogue.setting("retention") is None
    for years in ("10", "15"):
        catalogue.set(Setting(key="retention", content=years, by="anna"))
    newest = catalogue.setting("retention")
    assert newest is not None
    assert newest.content == "15"


def test_metrics_are_kept_by_digest_and_version(catalogue: Catalogue) -> None:
    digests = [sha(str(number)) for number in range(1200)]
    for digest in digests[::2]:
        catalogue.keep_metrics(digest, "v1", digest[:4])
    catalogue.keep_metrics(digests[0], "v1", "another")
    found = catalogue.kept_metrics(digests, "v1")
    assert found == {digest: digest[:4] for digest in digests[::2]}
    assert catalogue.kept_metrics(digests, "v2") == {}


def test_a_sign_in_ends_for_good(catalogue: Catalogue) -> None:
    first, second = (catalogue.add_sign_in(sha(word), "anna").id for word in ("one", "two"))
    other = catalogue.add_sign_in(sha("three"), "bert").id
    catalogue.see_sign_in(first)
    seen = catalogue.sign_in(first)
    assert seen is not None
    assert seen.seen_utc_ns > seen.issued_utc_ns
    catalogue.end_sign_ins("anna", first)
    assert [one.id for one in catalogue.sign_ins("anna")] == [second]
    catalogue.end_sign_ins("anna")
    assert catalogue.sign_ins("anna") == ()
    assert [one.id for one in catalogue.sign_ins("bert")] == [other]
    ended = catalogue.sign_in(first)
    assert ended is not None
    assert ended.ended_utc_ns > 0
    catalogue.forget_sign_ins(2**62)
    assert catalogue.sign_in(other) is None
