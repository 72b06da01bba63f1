"""What a catalogue keeps, over every engine it may stand on."""

from __future__ import annotations

import hashlib
import itertools
import threading
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from sqlalchemy import create_engine, text

from sessions.catalogue import (
    CameraCalibration,
    Catalogue,
    Exercise,
    Hand,
    Patient,
    PrescriptionRow,
    Take,
    TherapySession,
    User,
)
from sessions.errors import Refused
from tests.postgres_server import server

URLS: dict[str, Callable[[Path], str]] = {
    "sqlite": lambda folder: f"sqlite:///{folder / 'clinic.sqlite3'}",
    "postgresql": lambda _: server().fresh(),
}


def sha(word: str) -> str:
    return hashlib.sha256(word.encode()).hexdigest()


def take(word: str = "a", **changes: object) -> Take:
    plain = Take(
        sha256=sha(word),
        path=f"takes/{word}.mcap",
        side="right",
        exercise="fist",
        source="virtual-camera",
        duration_s=12.0,
        subject_id="T-1",
    )
    return replace(plain, **changes)


@pytest.fixture(params=sorted(URLS))
def url(request: pytest.FixtureRequest, tmp_path: Path) -> str:
    return URLS[request.param](tmp_path)


@pytest.fixture
def catalogue(url: str, tmp_path: Path) -> Iterator[Catalogue]:
    clock = itertools.count(1_790_000_000_000_000_000, 1000)
    with Catalogue.open(tmp_path, url, lambda: next(clock)) as opened:
        yield opened


def test_users(catalogue: Catalogue) -> None:
    added = catalogue.add_user(User(name="anna", role="therapist", password_hash="$argon2id$x"))
    assert added.id > 0
    assert catalogue.user("anna") == added
    off = catalogue.change_user(replace(added, active=False))
    assert catalogue.users() == (off,)
    with pytest.raises(Refused, match="already there"):
        catalogue.add_user(added)
    with pytest.raises(Refused, match="unknown"):
        catalogue.user("bob")
    with pytest.raises(Refused, match="role"):
        User(name="x", role="king", password_hash="")


def test_patients_get_pseudonyms_in_order(catalogue: Catalogue) -> None:
    first = catalogue.add_patient(Patient(given_name="A", side="left", birth_date="1950-02-01"))
    own = catalogue.add_patient(Patient(id="P-0003", side="right"))
    third = catalogue.add_patient(Patient(side="right"))
    assert [first.id, own.id, third.id] == ["P-0001", "P-0003", "P-0004"]
    hidden = catalogue.change_patient(replace(first, archived=True, impairment="stroke 2025"))
    assert catalogue.patients(archived=True) == (hidden,)
    assert [patient.id for patient in catalogue.patients()] == ["P-0003", "P-0004"]
    assert catalogue.patient("P-0001").impairment == "stroke 2025"
    with pytest.raises(Refused, match="already there"):
        catalogue.add_patient(own)
    with pytest.raises(Refused, match="unknown"):
        catalogue.change_patient(Patient(id="P-9999", side="left"))


@pytest.mark.parametrize(
    "bad", [{"side": "up"}, {"hand_length_m": 19.0}, {"birth_date": "1.2.1950"}, {"birth_date": "1950-02-31"}]
)
def test_patients_that_cannot_be_are_refused(bad: dict[str, object]) -> None:
    with pytest.raises(Refused):
        Patient(**{"side": "left", **bad})


def test_takes_are_found_by_id_digest_and_beginning(catalogue: Catalogue) -> None:
    first = catalogue.add_take(take("a"))
    second = catalogue.add_take(take("b", parent=first.id))
    assert first.id == sha("a")[:8]
    assert catalogue.take(first.id) == catalogue.take(sha("a")) == catalogue.take(sha("a")[:6]) == first
    assert second.parent == first.id
    assert catalogue.takes() == (second, first)
    assert catalogue.add_take(take("a", path="elsewhere.mcap")) == first
    for unknown in ("nothing", "", sha("a")[:5], "%", sha("c")):
        with pytest.raises(Refused, match="unknown"):
            catalogue.take(unknown)
    with pytest.raises(Refused, match="unknown"):
        catalogue.add_take(take("c", parent="ffffffff"))


def test_ids_grow_until_they_are_unique(catalogue: Catalogue) -> None:
    one, other = "ab" * 32, "ab" * 4 + "cd" * 28
    assert catalogue.add_take(take("x", sha256=one)).id == "ab" * 4
    assert catalogue.add_take(take("y", sha256=other)).id == "ab" * 4 + "c"
    with pytest.raises(Refused, match="ambiguous"):
        catalogue.take("ababab")


@pytest.mark.parametrize("path", ["/etc/passwd", "../x.mcap", "a/../../x.mcap", ""])
def test_files_outside_the_folder_are_refused(catalogue: Catalogue, path: str) -> None:
    with pytest.raises(Refused, match="inside the clinic folder"):
        catalogue.add_take(take("a", path=path))
    assert catalogue.takes() == ()


def test_one_file_is_one_recording(catalogue: Catalogue) -> None:
    catalogue.add_take(take("a"))
    with pytest.raises(Refused, match="file of its own"):
        catalogue.add_take(take("b", path="takes/a.mcap"))
    with pytest.raises(Refused, match="hexadecimal"):
        catalogue.add_take(take("c", sha256="zz"))


def test_approval_is_of_one_file_and_the_last_one_holds(catalogue: Catalogue) -> None:
    added = catalogue.add_take(take("a"))
    assert catalogue.approval(added.id) is None
    catalogue.approve(added.id, "anna")
    last = catalogue.approve(added.sha256, "berta")
    assert catalogue.approval(added.id) == last
    assert (last.take, last.digest, last.by) == (added.id, added.sha256, "berta")
    with pytest.raises(Refused, match="named therapist"):
        catalogue.approve(added.id, " ")
    with pytest.raises(Refused, match="unknown"):
        catalogue.approve("ffffffff", "anna")


def test_prescriptions_and_sessions(catalogue: Catalogue) -> None:
    patient = catalogue.add_patient(Patient(side="left"))
    played = catalogue.add_take(take("a"))
    ordered = PrescriptionRow(
        patient=patient.id, take=played.id, mode="passive", speed=0.5, repetitions=5, stiffness_multiple=3.0
    )
    stored = catalogue.add_prescription(ordered)
    assert catalogue.prescriptions(patient.id) == (stored,)
    run = TherapySession(
        patient=patient.id,
        take=played.id,
        sha256=sha("s"),
        path="sessions/s.mcap",
        mode="passive",
        started_utc_ns=5,
    )
    added = catalogue.add_session(run)
    nameless = catalogue.add_session(
        replace(run, patient="", sha256=sha("t"), path="sessions/t.mcap", started_utc_ns=9)
    )
    assert catalogue.session(added.id) == added
    assert catalogue.sessions() == (nameless, added)
    assert catalogue.sessions(patient.id) == (added,)
    assert catalogue.add_session(run) == added
    for stranger in (
        replace(run, sha256=sha("u"), take="ffffffff"),
        replace(run, sha256=sha("v"), patient="P-9"),
    ):
        with pytest.raises(Refused, match="unknown"):
            catalogue.add_session(replace(stranger, path="sessions/u.mcap"))
    with pytest.raises(Refused, match="unknown"):
        catalogue.session("nothing")
    with pytest.raises(Refused, match="unknown"):
        catalogue.sessions("P-9999")


def test_exercises(catalogue: Catalogue) -> None:
    catalogue.add_exercise(Exercise(name="hook fist", description="tendon glide"))
    catalogue.add_exercise(Exercise(name="hook fist", description="tendon glide 2"))
    catalogue.add_exercise(Exercise(name="finger abduction"))
    assert [item.name for item in catalogue.exercises()] == ["finger abduction", "hook fist"]
    assert catalogue.exercises()[1].description == "tendon glide 2"


def test_everything_is_there_after_closing(url: str, tmp_path: Path) -> None:
    with Catalogue.open(tmp_path, url) as first:
        added = first.add_take(take("a"))
    with Catalogue.open(tmp_path, url) as second:
        assert second.takes() == (added,)


@pytest.mark.parametrize(
    "damage",
    [
        "UPDATE audit SET detail = 'nothing happened' WHERE seq = 2",
        "UPDATE audit SET utc_ns = utc_ns + 1 WHERE seq = 3",
        "DELETE FROM audit WHERE seq = 1",
        "DELETE FROM audit WHERE seq = 2",
        "INSERT INTO audit SELECT 4, utc_ns, actor, verb, subject, detail, previous_hash, hash FROM audit"
        " WHERE seq = 3",
    ],
)
def test_the_audit_shows_what_was_done_to_it(catalogue: Catalogue, url: str, damage: str) -> None:
    for verb in ("sign-in", "approve", "play"):
        catalogue.record_audit("anna", verb, "7f3a", "as it was")
    assert catalogue.verify_audit() == 3
    assert [row.verb for row in catalogue.audit(2)] == ["play", "approve"]
    engine = create_engine(url)
    with engine.begin() as connection:
        connection.execute(text(damage))
    engine.dispose()
    with pytest.raises(Refused, match="audit row"):
        catalogue.verify_audit()


def test_an_empty_audit_is_unbroken(catalogue: Catalogue) -> None:
    assert catalogue.verify_audit() == 0


def test_many_threads_write_one_chain(catalogue: Catalogue) -> None:
    failed: list[Exception] = []

    def work(name: str) -> None:
        try:
            for number in range(10):
                catalogue.record_audit(name, "note", str(number))
                catalogue.add_patient(Patient(side="left"))
                catalogue.patients()
        except Refused as error:
            failed.append(error)

    threads = [threading.Thread(target=work, args=(f"user {n}",)) for n in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not failed
    assert catalogue.verify_audit() == 40
    assert len({patient.id for patient in catalogue.patients()}) == 40


def test_two_catalogues_on_one_folder(catalogue: Catalogue, url: str, tmp_path: Path) -> None:
    with Catalogue.open(tmp_path, url) as other:
        for number in range(5):
            catalogue.record_audit("one", "note", str(number))
            other.record_audit("two", "note", str(number))
        assert other.verify_audit() == 10


def test_camera_calibrations_are_added_and_never_changed(catalogue: Catalogue) -> None:
    first = catalogue.add_calibration(
        CameraCalibration(digest=sha("1"), camera="webcam:0", verdict="usable", content="{}")
    )
    second = catalogue.add_calibration(
        CameraCalibration(digest=sha("2"), camera="webcam:0", verdict="good", content="{}")
    )
    other = catalogue.add_calibration(
        CameraCalibration(digest=sha("3"), camera="kinect:0", verdict="good", content="{}")
    )
    assert catalogue.calibrations("webcam:0") == (second, first)
    assert catalogue.calibrations() == (other, second, first)
    assert catalogue.calibrations("webcam:9") == ()
    assert catalogue.add_calibration(replace(first, verdict="good", content="{1}")) == first
    assert catalogue.calibration(sha("1")[:8]) == catalogue.calibration(sha("1")) == first
    for wrong in (sha("4"), sha("1")[:5], "", "%" * 8):
        with pytest.raises(Refused, match="unknown"):
            catalogue.calibration(wrong)
    with pytest.raises(Refused, match="64 hexadecimal digits"):
        catalogue.add_calibration(replace(first, digest="short"))


def test_hands_are_kept_newest_first(catalogue: Catalogue) -> None:
    old = catalogue.add_hand(Hand(person="P-0001", side="right", protocol="thesis25", content="{}"))
    new = catalogue.add_hand(replace(old, content="{1}"))
    left = catalogue.add_hand(replace(old, side="left"))
    catalogue.add_hand(replace(old, person="P-0002"))
    assert catalogue.hands("P-0001") == (left, new, old)
    assert catalogue.hands("P-0001", "right", "thesis25") == (new, old)
    assert catalogue.hands("P-0001", "right", "fingertips5") == ()
    assert old.created_utc_ns < new.created_utc_ns
    with pytest.raises(Refused, match="side"):
        replace(old, side="upper")
    with pytest.raises(Refused, match="nobody"):
        replace(old, person=" ")
