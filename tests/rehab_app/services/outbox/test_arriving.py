"""What waited arrives once, whatever breaks off, and never in the place of another."""

from __future__ import annotations

import signal
import subprocess
import sys
from contextlib import contextmanager
from dataclasses import replace

from rehab_app.access import CONSOLE
from rehab_app.cli.doctor import examine
from rehab_app.config import ClinicFolder
from rehab_app.errors import NoAnswer
from rehab_app.services.outbox_catalogue import StationCatalogue, open_catalogue
from rehab_app.services.outbox_folder import OutboxFolder
from sessions.catalogue import (
    Catalogue,
    FitCheck,
    PatientEntry,
)

from .conftest import KILLED, LIMITS, MEMORY, away, details, session


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


def test_what_a_newer_one_overtook_does_not_count_again(room, url, tmp_path):
    limits = replace(LIMITS, content="old", expires_utc_ns=2000)
    memory = replace(MEMORY, content="old")
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
