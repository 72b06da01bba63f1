"""A station whose data base goes away: a real server, stopped in the middle and started again."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import threading
import time
from contextlib import contextmanager
from dataclasses import replace

import pytest

from rehab_app.access import CONSOLE
from rehab_app.bootstrap import open_clinic
from rehab_app.cli.doctor import examine
from rehab_app.config import ClinicFolder, Settings
from rehab_app.errors import NoAnswer, Refused
from rehab_app.services.journal import Note, PainReport
from rehab_app.services.left_over import unentered
from rehab_app.services.outbox_catalogue import StationCatalogue, open_catalogue
from rehab_app.services.outbox_folder import OutboxFolder
from sessions.catalogue import (
    AssistanceMemory,
    AuditFilter,
    Catalogue,
    DayLimits,
    FitCheck,
    Patient,
    PatientEntry,
    TherapySession,
)
from tests.postgres_server import server

PASSWORD = "correct horse battery"


@pytest.fixture
def url():
    return server().fresh()


@pytest.fixture
def room(tmp_path, url):
    """A clinic on PostgreSQL with a therapist and a patient, both looked up once."""
    with open_clinic(tmp_path / "room", settings=Settings(catalogue_url=url, station="room")) as clinic:
        clinic.accounts.add_user("anna", "administrator", PASSWORD, CONSOLE)
        clinic.patients.add(
            CONSOLE, given_name="Ida", family_name="Berg", birth_date="1957-03-14", side="left"
        )
        clinic.catalogue.patient("P-0001")
        yield clinic


@contextmanager
def away(room):
    """The server is gone, as when its machine loses power; behind the block it answers again."""
    server().stop()
    try:
        yield
    finally:
        server().start()
        while not answers(room.catalogue):
            threading.Event().wait(0.05)


def answers(catalogue):
    try:
        return catalogue.data_base_time_ns() > 0
    except NoAnswer:
        return False


def session(number, patient="P-0001"):
    return TherapySession(
        patient=patient,
        sha256=f"{number:064x}",
        path=f"sessions/{number:x}.mcap",
        mode="passive",
        started_utc_ns=1000,
    )


def details(catalogue, verb):
    rows, _ = catalogue.find_audit(AuditFilter(verb=verb), 0, 100)
    return [row.detail for row in reversed(rows)]


def test_what_ends_a_session_waits_and_arrives_once_in_order(room):
    catalogue = room.catalogue
    with away(room):
        for number in (0xA1, 0xB2):
            kept = catalogue.add_session(session(number << 240))
            catalogue.add_assistance(
                AssistanceMemory(
                    patient="P-0001", exercise="pinch", device="sim", content=f"{number}", session=kept.id
                )
            )
            catalogue.add_entry(
                PatientEntry(patient="P-0001", kind="pain", session=kept.id, content=f"[{number}]", by="anna")
            )
            room.audit.note(CONSOLE, "session", kept.id, f"number {number}")
        assert room.outbox.bring() == 0
        assert room.outbox.state().away
        assert room.outbox.state().waiting == 8
    assert room.outbox.bring() == 8
    assert room.outbox.bring() == 0
    assert not room.outbox.state().told
    found = catalogue.sessions("P-0001")
    assert sorted(one.sha256 for one in found) == sorted(f"{n << 240:064x}" for n in (0xA1, 0xB2))
    assert [one.content for one in catalogue.entries("P-0001", ["pain"])] == ["[178]", "[161]"]
    assert {one.session for one in catalogue.entries("P-0001", ["pain"])} == {one.id for one in found}
    assert catalogue.assistance("P-0001", "pinch", "sim").content == "178"
    said = details(catalogue, "session")
    assert [one.partition(";")[0] for one in said] == ["number 161", "number 178"]
    assert all("while the catalogue did not answer" in one and "done at 20" in one for one in said)
    catalogue.verify_audit()


def test_rows_keep_the_time_at_which_they_were_written(room):
    with away(room):
        written = room.journal.note(CONSOLE, "P-0001", "Relaxed today.")
    room.outbox.bring()
    (arrived,) = room.journal.entries("P-0001", ("note",))
    assert arrived.what == Note("Relaxed today.")
    assert arrived.id > 0
    assert abs(arrived.created_utc_ns - written.created_utc_ns) < 10**9
    newest = room.catalogue.audit(1)[0]
    assert newest.verb == "write note"
    assert newest.utc_ns > arrived.created_utc_ns


def test_what_comes_while_others_wait_stays_behind_them(room):
    with away(room):
        room.audit.note(CONSOLE, "one")
    room.audit.note(CONSOLE, "two")  # the server answers again, and nothing has been brought yet
    room.outbox.bring()
    room.audit.note(CONSOLE, "three")
    assert [row.verb for row in reversed(room.catalogue.audit(3))] == ["one", "two", "three"]


def test_a_recording_goes_on_and_can_be_looked_at(room):
    room.takes.record_virtual("open_close", "right", 1.5, 3, CONSOLE)
    room.takes.list()
    with away(room):
        summary = room.takes.record_virtual("open_close", "right", 1.5, 4, CONSOLE)
        row = room.takes.get(summary.take)
        assert row.path.is_file()
        assert row.approved_by is None
        assert summary.take in [one.id for one in room.takes.list()]
        assert room.takes.motion(summary.take).t_s.size > 0
        with pytest.raises(NoAnswer):
            room.takes.approve(summary.take, CONSOLE)
    room.outbox.bring()
    assert room.catalogue.take(summary.take).sha256 == row.sha256
    assert len(room.catalogue.takes()) == 2
    room.takes.approve(summary.take, CONSOLE)


def test_a_commit_of_which_nobody_knows_is_not_written_twice(room, monkeypatch):
    once = Catalogue.once

    @contextmanager
    def cut(self, delivery, utc_ns=0):
        with once(self, delivery, utc_ns) as new:
            yield new
        raise NoAnswer("clinic data base", "not answering (cut)", "there", "wait")

    with monkeypatch.context() as wire:
        wire.setattr(StationCatalogue, "once", cut)
        room.catalogue.add_entry(PatientEntry(patient="P-0001", kind="note", content="{}", by="anna"))
        room.audit.note(CONSOLE, "once only")
    assert room.outbox.state().waiting == 2
    room.outbox.bring()
    assert len(room.catalogue.entries("P-0001", ["note"])) == 1
    assert len(details(room.catalogue, "once only")) == 1
    assert OutboxFolder(room.folder).aside() == ()


KILLED = """
import os, signal, sys
from pathlib import Path
from rehab_app.services.outbox import Outbox
from rehab_app.services.outbox_catalogue import open_catalogue
from rehab_app.services.outbox_folder import OutboxFolder

before, left = OutboxFolder.remove, int(sys.argv[3])

def remove(self, path):
    global left
    left -= 1
    if left == 0:
        os.kill(os.getpid(), signal.SIGKILL)
    before(self, path)

OutboxFolder.remove = remove
Outbox(open_catalogue(Path(sys.argv[1]), sys.argv[2])).bring()
"""


def test_a_kill_between_arrival_and_removal_does_nothing_twice(room, url):
    with away(room):
        for number in range(1, 7):
            room.catalogue.add_session(session(number))
            room.catalogue.add_entry(
                PatientEntry(patient="P-0001", kind="pain", content=f"[{number}]", by="anna")
            )
    for nth in (1, 2, 4):
        done = subprocess.run([sys.executable, "-c", KILLED, str(room.folder), url, str(nth)], check=False)
        assert done.returncode == -signal.SIGKILL
    assert 0 < room.outbox.state().waiting < 12
    room.outbox.bring()
    contents = [one.content for one in room.catalogue.entries("P-0001", ["pain"])]
    assert contents == [f"[{number}]" for number in range(6, 0, -1)]
    assert len(room.catalogue.sessions("P-0001")) == 6
    assert OutboxFolder(room.folder).aside() == ()


def test_one_that_cannot_arrive_is_set_aside_and_the_rest_goes_on(room):
    outbox = OutboxFolder(room.folder)
    with away(room):
        room.audit.note(CONSOLE, "first")
        room.catalogue.add_session(session(5, patient="P-0999"))
        room.audit.note(CONSOLE, "damaged")
        room.audit.note(CONSOLE, "unknown kind")
        room.audit.note(CONSOLE, "last")
    names = outbox.names()
    (outbox.folder / names[2]).write_bytes(b'{"id": "tor')
    unknown = outbox.folder / names[3]
    unknown.write_bytes(unknown.read_bytes().replace(b'"kind":"audit"', b'"kind":"spell"'))
    assert room.outbox.bring() == 2
    assert [row.verb for row in reversed(room.catalogue.audit(2))] == ["first", "last"]
    assert [one.name for one in outbox.aside()] == list(names[1:4])
    told = [one for one in examine(ClinicFolder(room.folder), 1) if one.name == "outbox"]
    assert [one.ok for one in told] == [False] * 3
    assert "P-0999" in told[0].found
    assert "damaged" in told[1].found
    assert "spell" in told[2].found
    assert all(one.remedy for one in told)


def test_of_somebody_who_was_erased_meanwhile_no_word_is_kept(room, url, tmp_path):
    with away(room):
        room.catalogue.add_session(session(7))
        room.journal.note(CONSOLE, "P-0001", "Something very private.")
        room.audit.note(CONSOLE, "last")
    with open_catalogue(tmp_path / "other", url) as other:
        other.erase_patient("P-0001", "[]", "anna")
    room.outbox.bring()
    aside = OutboxFolder(room.folder).folder / "aside"
    kept = b"".join(path.read_bytes() for path in aside.iterdir())
    assert b"sessions/7.mcap" in kept
    assert b"private" not in kept
    assert room.catalogue.sessions() == ()
    assert room.catalogue.audit(1)[0].verb == "last"
    why = [one.why for one in OutboxFolder(room.folder).aside()]
    assert len(why) == 2
    assert all("erased meanwhile" in one for one in why)


def test_what_was_measured_meanwhile_holds_at_once(room):
    """The next run is planned within it, and not within what the catalogue said last."""
    old = DayLimits(
        patient="P-0001",
        side="left",
        device="sim",
        wrist_rad=0.0,
        content="wide",
        measured_utc_ns=1000,
        expires_utc_ns=9000,
        by="anna",
    )
    memory = AssistanceMemory(patient="P-0001", exercise="pinch", device="sim", content="more", session="")
    first = room.catalogue.add_session(session(1))
    room.catalogue.add_day_limits(old)
    room.catalogue.add_assistance(replace(memory, session=first.id))
    assert len(room.catalogue.day_limits("P-0001", "sim")) == 1
    with away(room):
        held = room.catalogue.add_session(session(2))
        room.catalogue.add_day_limits(replace(old, measured_utc_ns=2000, content="narrow"))
        room.catalogue.add_assistance(replace(memory, content="less", session=held.id))
        contents = [one.content for one in room.catalogue.day_limits("P-0001", "sim")]
        assert contents == ["narrow", "wide"]
        assert room.catalogue.assistance("P-0001", "pinch", "sim").content == "less"
    for _ in range(2):
        assert [one.content for one in room.catalogue.day_limits("P-0001", "sim")] == ["narrow", "wide"]
        assert room.catalogue.assistance("P-0001", "pinch", "sim").content == "less"
        room.outbox.bring()


def test_what_a_newer_one_overtook_does_not_count_again(room, url, tmp_path):
    limits = DayLimits(
        patient="P-0001",
        side="left",
        device="sim",
        wrist_rad=0.0,
        content="old",
        measured_utc_ns=1000,
        expires_utc_ns=2000,
        by="anna",
    )
    memory = AssistanceMemory(patient="P-0001", exercise="pinch", device="sim", content="old", session="")
    with away(room):
        held = room.catalogue.add_session(session(1))
        room.catalogue.add_day_limits(limits)
        room.catalogue.add_assistance(replace(memory, session=held.id))
    with open_catalogue(tmp_path / "other", url) as other:
        there = other.add_session(session(2))
        other.add_day_limits(replace(limits, measured_utc_ns=1500, content="new"))
        other.add_assistance(replace(memory, content="new", session=there.id))
    room.outbox.bring()
    assert room.catalogue.day_limits("P-0001", "sim")[0].content == "new"
    assert room.catalogue.assistance("P-0001", "pinch", "sim").content == "new"
    assert len(room.catalogue.sessions("P-0001")) == 2
    assert len(OutboxFolder(room.folder).aside()) == 2


def test_an_id_that_turns_out_to_be_anothers_leads_to_the_right_session(room, url, tmp_path):
    """Two digests that begin alike: the id that stood in for the one is the other's by then."""
    mine, theirs = (
        replace(session(1), sha256="ab" * 4 + end * 28, path=f"sessions/{end}") for end in ("11", "22")
    )
    with away(room):
        kept = room.catalogue.add_session(mine)
        check = FitCheck(
            patient="P-0001", side="left", device="sim", content="{}", verdict="", session=kept.id, by="anna"
        )
        room.catalogue.add_fit_check(check)
    with open_catalogue(tmp_path / "other", url) as other:
        assert other.add_session(theirs).id == kept.id
    room.outbox.bring()
    (found,) = room.catalogue.fit_checks("P-0001", "sim")
    assert room.catalogue.session(found.session).sha256 == mine.sha256


def test_new_people_and_decisions_are_refused_in_one_sentence(room):
    refused = (
        lambda: room.accounts.sign_in("anna", PASSWORD),
        lambda: room.patients.add(CONSOLE, given_name="A", family_name="B", birth_date="", side="left"),
        lambda: room.catalogue.add_entry(
            PatientEntry(patient="P-0001", kind="plan", content="{}", by="anna")
        ),
        lambda: room.catalogue.claim_patient("P-0001", "room", "x", 10**9),
        lambda: room.live.start_therapy(CONSOLE, "P-0001", "abcdefgh"),
    )
    with away(room):
        for act in refused:
            with pytest.raises(NoAnswer, match="not answering") as told:
                act()
            assert "\n" not in str(told.value)
        assert "sign in" not in [
            letter.row.content.get("verb") for letter in OutboxFolder(room.folder).waiting()
        ]
    room.accounts.sign_in("anna", PASSWORD)


def test_whoever_is_signed_in_stays_so_until_they_leave(room, monkeypatch):
    digest, sign_ins = "d" * 64, room.accounts.sign_ins
    sign_ins.begin("anna", digest)
    room.accounts.account("anna")
    sign_ins.look("anna", digest)
    with away(room):
        monkeypatch.setattr(sign_ins, "_clock_ns", lambda: time.time_ns() + 5 * 10**9)  # it is asked again
        assert sign_ins.look("anna", digest) is not None
        assert room.accounts.account("anna").role == "administrator"
        assert room.accounts.unlock("anna", PASSWORD).name == "anna"
        with pytest.raises(Refused, match="wrong"):
            room.accounts.unlock("anna", "guessed")
        sign_ins.end("anna", digest)
        with pytest.raises(NoAnswer):
            sign_ins.look("anna", digest)
    room.outbox.bring()
    assert sign_ins.look("anna", digest) is None


def test_a_pain_is_written_without_the_catalogue_and_a_correction_is_not(room):
    first = room.journal.pain(CONSOLE, "P-0001", PainReport(3, "thumb", "during"))
    with away(room):
        room.journal.pain(CONSOLE, "P-0001", PainReport(7, "index", "during"))
        with pytest.raises(NoAnswer):
            room.journal.pain(CONSOLE, "P-0001", PainReport(2, "", "during"), corrects=first.id)
    room.outbox.bring()
    assert [one.score for one in room.journal.pain_course("P-0001")] == [3, 7]


def test_rows_that_are_written_behind_the_act_wait_too(room):
    """The thread that writes them lives on."""
    with away(room):
        room.live.press_stop("a foot switch")
        end = threading.Event()
        while room.outbox.state().waiting == 0:
            end.wait(0.02)
    room.live.clear_stop(CONSOLE, confirmed=True)
    room.audit.close()
    room.outbox.bring()
    assert [row.verb for row in reversed(room.catalogue.audit(2))] == ["stop", "clear stop"]


def test_the_server_brings_by_itself_what_waited(room):
    room.outbox.start()
    with away(room):
        room.audit.note(CONSOLE, "by itself")
    end = threading.Event()
    while room.outbox.state().told:
        end.wait(0.02)
    assert len(details(room.catalogue, "by itself")) == 1


def test_what_waited_is_brought_at_the_next_start(tmp_path, url):
    settings = Settings(catalogue_url=url)
    with open_clinic(tmp_path / "room", settings=settings) as clinic, away(clinic):
        clinic.audit.note(CONSOLE, "before the end")
    with open_clinic(tmp_path / "room", settings=settings) as clinic:
        assert len(details(clinic.catalogue, "before the end")) == 1
        assert clinic.outbox.state().waiting == 0


def test_a_recording_that_waits_is_not_taken_for_one_that_nobody_entered(room):
    file = room.folder / "sessions" / "9.mcap"
    file.write_bytes(b"sealed")
    os.utime(file, (1.0, 1.0))
    folder = ClinicFolder(room.folder)
    assert unentered(folder, room.catalogue) == (file,)
    with away(room):
        room.catalogue.add_session(session(9))
    assert unentered(folder, room.catalogue) == ()


def test_a_server_that_stands_still_is_not_waited_for(room):
    """It holds its connections and says nothing: neither TCP nor its own time-outs would ever tell."""
    room.catalogue.users()
    frozen = server().processes()
    for process in frozen:
        os.kill(process, signal.SIGSTOP)
    try:
        with pytest.raises(NoAnswer, match="not answering"):
            room.catalogue.users()
        assert room.outbox.state().away
        room.audit.note(CONSOLE, "meanwhile")
    finally:
        for process in frozen:
            os.kill(process, signal.SIGCONT)
    room.outbox.bring()
    assert len(details(room.catalogue, "meanwhile")) == 1


def test_a_network_that_swallows_everything_is_not_waited_for(tmp_path):
    with socket.socket() as silent:
        silent.bind(("127.0.0.1", 0))
        silent.listen()
        address = f"postgresql://clinic:x@127.0.0.1:{silent.getsockname()[1]}/clinic"
        with pytest.raises(NoAnswer, match="not answering"):
            open_catalogue(tmp_path, address)


def test_a_clinic_in_a_file_has_no_outbox(tmp_path):
    with open_clinic(tmp_path / "clinic", settings=Settings()) as clinic:
        assert type(clinic.catalogue) is Catalogue
        clinic.catalogue.add_patient(Patient(side="left"))
        clinic.outbox.start()
        clinic.catalogue.add_session(session(1))
        clinic.journal.note(CONSOLE, "P-0001", "Relaxed.")
        assert clinic.outbox.bring() == 0
        assert clinic.outbox.state().told is False
        assert "outbox" not in [thread.name for thread in threading.enumerate()]
        assert not (clinic.folder / "outbox").exists()
        with clinic.catalogue._reading() as reading:
            assert reading.connection().exec_driver_sql("SELECT count(*) FROM deliveries").scalar() == 0
    assert [one.name for one in examine(ClinicFolder(tmp_path / "clinic"), 1) if one.name == "outbox"] == []
