"""What was done without the catalogue waits, in order, and counts meanwhile."""

from __future__ import annotations

import threading
import time
from dataclasses import replace

import pytest

from rehab_app.access import CONSOLE
from rehab_app.errors import NoAnswer, Refused
from rehab_app.services.journal import Note, PainReport
from rehab_app.services.outbox_folder import OutboxFolder
from sessions.catalogue import (
    AssistanceMemory,
    PatientEntry,
)

from .conftest import LIMITS, MEMORY, PASSWORD, away, details, session


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


def test_what_was_measured_meanwhile_holds_at_once(room):
    """The next run is planned within it, and not within what the catalogue said last."""
    first = room.catalogue.add_session(session(1))
    room.catalogue.add_day_limits(LIMITS)
    room.catalogue.add_assistance(replace(MEMORY, session=first.id))
    assert len(room.catalogue.day_limits("P-0001", "sim")) == 1
    with away(room):
        held = room.catalogue.add_session(session(2))
        room.catalogue.add_day_limits(replace(LIMITS, measured_utc_ns=2000, content="narrow"))
        room.catalogue.add_assistance(replace(MEMORY, content="less", session=held.id))
        contents = [one.content for one in room.catalogue.day_limits("P-0001", "sim")]
        assert contents == ["narrow", "wide"]
        assert room.catalogue.assistance("P-0001", "pinch", "sim").content == "less"
    for _ in range(2):
        assert [one.content for one in room.catalogue.day_limits("P-0001", "sim")] == ["narrow", "wide"]
        assert room.catalogue.assistance("P-0001", "pinch", "sim").content == "less"
        room.outbox.bring()


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
