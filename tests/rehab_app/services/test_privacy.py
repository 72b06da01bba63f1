"""Erasing one patient leaves nothing of them and everything of the others; export holds it all."""

from __future__ import annotations

import zipfile

import msgspec
import pytest

from rehab_app.access import CONSOLE, Account
from rehab_app.bootstrap import open_clinic
from rehab_app.errors import Refused
from rehab_app.services import storage
from rehab_app.services.erased_ledger import LEDGER
from rehab_app.services.recording_request import RecordingRequest
from rehab_app.services.retention import USUAL_YEARS, Retention
from sessions.catalogue import Hand, PatientEntry, Take, TherapySession
from sessions.catalogue.erasure import UNFINISHED
from sessions.store import SessionReader

GONE, OTHER = "P-0001", "P-0002"


def sealed(clinic, folder, word):
    """A file of the clinic folder that stands for a sealed one."""
    path = clinic.folder / folder / f"{word}.mcap"
    path.write_bytes(word.encode())
    digest = storage.digest(path)
    storage.digest_beside(path).write_text(digest)
    (clinic.folder / "reports" / f"{word}.html").write_text("report")
    return path.relative_to(clinic.folder).as_posix(), digest


def stock(clinic):
    """Two patients; a take of the first one's hand that only the first uses, and one that both use."""
    for name in ("Meyer-Gone", "Stays"):
        clinic.patients.add(CONSOLE, given_name="Ada", family_name=name, birth_date="1950-01-01", side="left")
    takes = []
    for word in ("own", "shared"):
        path, digest = sealed(clinic, "takes", word)
        take = Take(
            sha256=digest,
            path=path,
            side="left",
            exercise="fist",
            source="x",
            duration_s=1.0,
            subject_id=GONE,
        )
        takes.append(clinic.catalogue.add_take(take))
    for patient, take, word in ((GONE, takes[0], "one"), (GONE, takes[1], "two"), (OTHER, takes[1], "three")):
        path, digest = sealed(clinic, "sessions", word)
        clinic.catalogue.keep_metrics(digest, "v", "{}")
        clinic.catalogue.add_session(
            TherapySession(
                patient=patient, take=take.id, sha256=digest, path=path, mode="passive", started_utc_ns=5
            )
        )
        clinic.catalogue.add_entry(
            PatientEntry(patient=patient, kind="note", content='"a secret note"', by="anna")
        )
    clinic.catalogue.add_hand(Hand(person=GONE, side="left", protocol="thesis25", content="{}"))
    return takes


@pytest.fixture
def clinic(tmp_path):
    with open_clinic(tmp_path / "clinic") as opened:
        yield opened


def names_of(clinic):
    return {path.name for path in clinic.folder.rglob("*") if path.is_file()}


def test_nothing_of_an_erased_patient_is_left(clinic):
    own = stock(clinic)[0]
    clinic.privacy.erasures.erase(CONSOLE, GONE, GONE)
    left = clinic.catalogue.patient_rows(GONE)
    assert {table: rows for table, rows in left.items() if rows}.keys() == {"patients"}
    kept = clinic.catalogue.patient(GONE)
    assert (kept.given_name, kept.family_name, kept.birth_date, kept.archived) == ("", "", "", True)
    for word in ("one", "two", "own"):
        assert not {f"{word}.mcap", f"{word}.mcap.sha256", f"{word}.html"} & names_of(clinic)
    with pytest.raises(Refused):
        clinic.catalogue.take(own.id)
    clinic.catalogue.close()
    raw = b"".join(path.read_bytes() for path in clinic.folder.glob("clinic.sqlite3*"))
    assert b"Meyer-Gone" not in raw
    assert raw.count(b"a secret note") == 1


def test_nothing_of_the_others_is_touched(clinic):
    shared = stock(clinic)[1]
    before = clinic.catalogue.patient_rows(OTHER)
    clinic.privacy.erasures.erase(CONSOLE, GONE, GONE)
    assert clinic.catalogue.patient_rows(OTHER) == before
    assert {"three.mcap", "three.mcap.sha256", "three.html", "shared.mcap"} <= names_of(clinic)
    assert clinic.catalogue.take(shared.id).subject_id == "erased"
    assert clinic.catalogue.verify_audit() > 0


def test_the_pseudonym_is_never_given_again(clinic):
    stock(clinic)
    clinic.privacy.erasures.erase(CONSOLE, OTHER, OTHER)
    added = clinic.patients.add(
        CONSOLE, given_name="New", family_name="Patient", birth_date="1960-01-01", side="left"
    )
    assert added.id == "P-0003"


def test_what_was_interrupted_is_finished_at_the_next_start(clinic, monkeypatch):
    stock(clinic)
    with monkeypatch.context() as broken:
        broken.setattr(type(clinic.privacy.erasures), "finish", lambda self: None)  # the power went
        clinic.privacy.erasures.erase(CONSOLE, GONE, GONE)
    assert "one.mcap" in names_of(clinic)
    folder = clinic.folder
    with open_clinic(folder) as again:
        assert not {"one.mcap", "two.mcap", "own.mcap", "one.html"} & names_of(again)
        assert again.catalogue.setting(UNFINISHED) is not None
        assert again.catalogue.setting(UNFINISHED).content == "[]"


def test_erasing_asks_twice_and_only_those_who_may(clinic):
    stock(clinic)
    with pytest.raises(Refused, match="the pseudonym P-0001"):
        clinic.privacy.erasures.erase(CONSOLE, GONE, "P-0002")
    with pytest.raises(Refused, match="may not erase"):
        clinic.privacy.erasures.erase(Account("t", "therapist", "2"), GONE, GONE)
    with pytest.raises(Refused, match="P-9999"):
        clinic.privacy.erasures.erase(CONSOLE, "P-9999", "P-9999")
    assert not (clinic.folder / LEDGER).exists()
    assert clinic.catalogue.patient(GONE).family_name == "Meyer-Gone"


def test_an_export_holds_everything_and_names_in_one_file_only(clinic, tmp_path):
    stock(clinic)
    target = tmp_path / "one.zip"
    names = clinic.privacy.exports.export(CONSOLE, GONE, target)
    assert {"sessions/one.mcap", "sessions/two.mcap", "takes/own.mcap", "reports/one.html"} <= set(names)
    assert "sessions/three.mcap" not in names
    with zipfile.ZipFile(target) as archive:
        texts = {name: archive.read(name) for name in names}
    assert [name for name, text in texts.items() if b"Meyer-Gone" in text] == ["identity.json"]
    rows = msgspec.json.decode(texts["record.json"])
    assert len(rows["patient_entries"]) == 2
    assert len(rows["therapy_sessions"]) == 2
    assert target.stat().st_mode & 0o077 == 0
    with pytest.raises(Refused, match="there already"):
        clinic.privacy.exports.export(CONSOLE, GONE, target)
    with pytest.raises(Refused, match="may not export"):
        clinic.privacy.exports.export(Account("a", "assistant", "2"), GONE, tmp_path / "two.zip")
    assert not (tmp_path / "two.zip").exists()


def test_who_is_due_is_told_and_nobody_is_erased(clinic):
    stock(clinic)
    added_ns = clinic.catalogue.patient(GONE).created_utc_ns
    year_ns = int(365.25 * 86400e9)
    later = Retention(clinic.catalogue, clinic.audit, lambda: added_ns + (USUAL_YEARS + 1) * year_ns)
    sooner = Retention(clinic.catalogue, clinic.audit, lambda: added_ns + (USUAL_YEARS - 1) * year_ns)
    assert set(later.due()) == {GONE, OTHER}
    assert sooner.due() == ()
    later.set_years(CONSOLE, 0)
    assert later.due() == ()
    clinic.privacy.erasures.erase(CONSOLE, GONE, GONE)
    later.set_years(CONSOLE, 1)
    assert later.due() == (OTHER,)
    with pytest.raises(Refused, match=r"0 .keep. to 100 years"):
        later.set_years(CONSOLE, 101)


def test_consent_is_what_was_said_last(clinic):
    stock(clinic)
    consents = clinic.privacy.consents
    assert not consents.given(GONE)
    consents.state(CONSOLE, GONE, True, "signed form")
    assert consents.given(GONE)
    consents.state(CONSOLE, GONE, False)
    assert not consents.given(GONE)
    assert [one.consent.given for one in consents.history(GONE)] == [False, True]
    with pytest.raises(Refused, match="501 characters"):
        consents.state(CONSOLE, GONE, True, "x" * 501)


def test_withdrawn_images_are_gone_and_the_movement_stays(clinic):
    clinic.patients.add(CONSOLE, given_name="Ada", family_name="Image", birth_date="1950-01-01", side="right")
    asked = RecordingRequest(
        exercise="open_close", side="right", seconds=1.0, person=GONE, consent_images=True
    )
    clinic.takes.record(asked, CONSOLE)
    (old,) = clinic.takes.list()
    assert clinic.privacy.consents.with_images(GONE) == (old.id,)
    with SessionReader(old.path) as reader:
        before = {name: count for name, count in reader.counts.items() if not name.startswith("/camera/")}
    (new,) = clinic.privacy.consents.remove_images(CONSOLE, GONE)
    assert clinic.privacy.consents.with_images(GONE) == ()
    row = clinic.takes.get(new)
    with SessionReader(row.path) as reader:
        after = {name: count for name, count in reader.counts.items() if not name.startswith("/camera/")}
        assert not reader.header.consent_images
        assert reader.header.parents == (old.sha256,)
        assert not any(name in reader.counts for name in ("/camera/color", "/camera/depth"))
    after["/events"] -= 1
    before.setdefault("/events", 0)
    assert after == before
    assert not old.path.exists()
