"""A patient is in therapy at one station only, and no trouble with that ever reaches a run that goes on."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from rehab_app.errors import Refused
from rehab_app.services.audit import Audit
from rehab_app.services.station_claims import SAME_SESSION_S, Claims, identity_of
from rehab_app.services.station_marks import FOLDER, StationMarks
from sessions.catalogue import Catalogue, Patient
from sessions.errors import NoAnswer
from tests.contracts.test_catalogue import URLS

PATIENCE_S = 60.0


class Rooms:
    """Two stations, each with a catalogue of its own on one data base."""

    def __init__(self, folder: Path, url: str) -> None:
        self.folder = folder
        self.catalogues = [Catalogue.open(folder, url) for _ in range(2)]
        self.audits = [Audit(one) for one in self.catalogues]
        self.patient = self.catalogues[0].add_patient(Patient(side="right")).id
        self._claims: list[Claims] = []

    def claims(self, room: int, lasts_s: float = 60.0, renew_s: float = 20.0) -> Claims:
        identity = identity_of(f"room-{room + 1}", "1.0")
        marks = StationMarks(self.folder / f"room-{room + 1}", identity.holder)
        made = Claims(self.catalogues[room], self.audits[room], identity, marks, lasts_s, renew_s)
        self._claims.append(made)
        return made

    def close(self) -> None:
        for claims in self._claims:
            claims.close()
        for audit in self.audits:
            audit.close()
        for catalogue in self.catalogues:
            catalogue.close()


@pytest.fixture(params=sorted(URLS))
def rooms(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Rooms]:
    made = Rooms(tmp_path, URLS[request.param](tmp_path))
    yield made
    made.close()


def until(wanted: Callable[[], object]) -> None:
    end_s, pause = time.monotonic() + PATIENCE_S, threading.Event()
    while not wanted():
        assert time.monotonic() < end_s, "it never came"
        pause.wait(0.01)


def test_the_other_station_is_refused_until_therapy_ends(rooms: Rooms) -> None:
    one, two = rooms.claims(0), rooms.claims(1)
    with one.held(rooms.patient):
        with pytest.raises(Refused, match="in therapy at station room-1 since") as told:
            two.start(rooms.patient)
        assert "\n" not in str(told.value)
        with one.held(rooms.patient):  # the run within the therapy
            pass
        with pytest.raises(Refused, match="room-1"):
            two.start(rooms.patient)
    until(lambda: not rooms.catalogues[1].claims())
    two.start(rooms.patient)
    assert [claim.station for claim in rooms.catalogues[0].claims()] == ["room-2"]


def test_a_demonstration_claims_nobody(rooms: Rooms) -> None:
    one = rooms.claims(0)
    with one.held(""):
        assert rooms.catalogues[0].claims() == ()


def test_two_threads_of_two_stations_race_and_one_wins(rooms: Rooms) -> None:
    gate, won, told = threading.Barrier(2), list[str](), list[str]()

    def start(claims: Claims) -> None:
        gate.wait()
        try:
            claims.start(rooms.patient)
            won.append(claims.identity.name)
        except Refused as refusal:
            told.append(str(refusal))

    threads = [threading.Thread(target=start, args=(rooms.claims(room),)) for room in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(won) == len(told) == 1
    assert f"at station {won[0]} since" in told[0]


def test_a_claim_is_renewed_beyond_its_length(rooms: Rooms) -> None:
    one = rooms.claims(0, lasts_s=30.0, renew_s=0.02)
    one.start(rooms.patient)
    (first,) = rooms.catalogues[1].claims()
    until(lambda: rooms.catalogues[1].claims()[0].until_utc_ns > first.until_utc_ns)
    (renewed,) = rooms.catalogues[1].claims()
    assert (renewed.holder, renewed.since_utc_ns) == (first.holder, first.since_utc_ns)
    assert one.trouble == ""


def test_a_dead_station_is_taken_over_and_the_audit_says_so(rooms: Rooms) -> None:
    dead, living = rooms.claims(0, lasts_s=0.0), rooms.claims(1)
    dead.start(rooms.patient)
    rooms.audits[1].start()
    living.start(rooms.patient)
    rooms.audits[1].close()
    (row,) = [row for row in rooms.catalogues[0].audit(10) if row.verb == "take over patient"]
    assert (row.actor, row.subject) == ("room-2", rooms.patient)
    assert "room-1" in row.detail


PROGRAM = """
import sys, time
from pathlib import Path
from rehab_app.services.station_marks import StationMarks
StationMarks(Path(sys.argv[1]), "killed").take()
print("taken", flush=True)
time.sleep(600)
"""


def test_what_a_killed_process_of_this_folder_held_is_free_at_once(rooms: Rooms) -> None:
    one = rooms.claims(0)
    folder = rooms.folder / "room-1"
    with subprocess.Popen(
        [sys.executable, "-c", PROGRAM, str(folder)], stdout=subprocess.PIPE, text=True
    ) as server:
        assert server.stdout is not None
        assert server.stdout.readline() == "taken\n"
        rooms.catalogues[0].claim_patient(rooms.patient, "room-1", "killed", 10**12)
        with pytest.raises(Refused, match="in therapy at station room-1"):
            one.start(rooms.patient)  # it lives
        server.kill()
    with pytest.raises(Refused, match="in therapy at station room-1"):
        rooms.claims(1).start(rooms.patient)  # of another machine's processes nothing is known
    rooms.audits[0].start()
    one.start(rooms.patient)
    rooms.audits[0].close()
    (row,) = [row for row in rooms.catalogues[0].audit(10) if row.verb == "take over patient"]
    assert row.detail == "at room-1, the claim of room-1 died with its process"


def test_marks_go_with_their_process_and_old_ones_are_tidied(tmp_path: Path) -> None:
    mine, beside = StationMarks(tmp_path, "mine"), StationMarks(tmp_path, "beside")
    mine.take()
    mine.take()
    beside.take()
    assert mine.gone() == frozenset()
    died = tmp_path / FOLDER / "died.lock"
    died.touch()
    assert mine.gone() == {"died"}
    os.utime(died, (0, 0))
    beside.release()
    beside.take()
    assert mine.gone() == frozenset()
    mine.release()
    beside.release()
    mine.release()
    assert list((tmp_path / FOLDER).iterdir()) == []


def test_a_folder_that_cannot_be_written_is_a_sentence(tmp_path: Path) -> None:
    (tmp_path / FOLDER).touch()
    with pytest.raises(Refused, match=r"station mark is .*make the clinic folder writable"):
        StationMarks(tmp_path, "mine").take()


def test_a_station_that_lost_its_claim_goes_on_and_is_told(rooms: Rooms) -> None:
    away, other = rooms.claims(0, lasts_s=0.0), rooms.claims(1)
    away.start(rooms.patient)
    other.start(rooms.patient)
    away.renew()
    assert "therapy here goes on" in away.trouble
    assert "room-2" in away.trouble
    away.end(rooms.patient)
    away.close()
    assert [claim.station for claim in rooms.catalogues[1].claims()] == ["room-2"]


def test_a_catalogue_that_does_not_answer_stops_and_delays_nothing(
    rooms: Rooms, monkeypatch: pytest.MonkeyPatch
) -> None:
    one = rooms.claims(0, renew_s=0.02)
    one.start(rooms.patient)
    asked, gone = threading.Event(), threading.Event()

    def silent(*_: object) -> None:
        asked.set()
        gone.wait(PATIENCE_S)
        raise NoAnswer("clinic data base", "not answering", "one that answers", "check the network")

    with monkeypatch.context() as away:
        away.setattr(Catalogue, "claim_patient", silent)
        assert asked.wait(PATIENCE_S)  # the renewal hangs from here on
        one.start(rooms.patient)  # the run within the therapy
        one.end(rooms.patient)
        one.end(rooms.patient)
        assert asked.is_set()
        assert not gone.is_set()  # both ended while the catalogue was still silent
        one.start("")
        gone.set()
        until(lambda: "not answering" in one.trouble)
    until(lambda: not rooms.catalogues[1].claims())


def test_a_patient_who_begins_again_at_once_is_not_set_free(rooms: Rooms) -> None:
    one = rooms.claims(0)
    for _ in range(20):  # the next exercise of a session: the end of the last is told on another thread
        one.start(rooms.patient)
        one.end(rooms.patient)
    one.start(rooms.patient)
    other = rooms.catalogues[0].add_patient(Patient(side="left")).id
    one.start(other)
    one.end(other)
    until(lambda: other not in [claim.patient for claim in rooms.catalogues[1].claims()])
    assert [claim.patient for claim in rooms.catalogues[1].claims()] == [rooms.patient]
    one.close()
    assert rooms.catalogues[1].claims() == ()


def test_without_the_catalogue_a_session_is_finished_and_none_begun(
    rooms: Rooms, monkeypatch: pytest.MonkeyPatch
) -> None:
    now_s = [1000.0]
    identity = identity_of("room-1", "1.0")
    claims = Claims(
        rooms.catalogues[0],
        rooms.audits[0],
        identity,
        StationMarks(rooms.folder, "one"),
        clock_s=lambda: now_s[0],
    )
    stranger = rooms.catalogues[0].add_patient(Patient(side="left")).id
    with claims.held(rooms.patient):
        pass
    until(lambda: not rooms.catalogues[1].claims())

    def away(*_: object) -> None:
        raise NoAnswer("clinic data base", "not answering", "one that answers", "check the network")

    with monkeypatch.context() as cut:
        cut.setattr(Catalogue, "claim_patient", away)
        cut.setattr(Catalogue, "release_patient", away)
        now_s[0] += SAME_SESSION_S
        with claims.held(rooms.patient):  # the next exercise of the session
            assert "goes on here without a claim" in claims.trouble
        with pytest.raises(NoAnswer, match="not answering"):
            claims.start(stranger)
        now_s[0] += SAME_SESSION_S + 1.0
        with pytest.raises(NoAnswer, match="not answering"):
            claims.start(rooms.patient)
        now_s[0] -= 1.0
        claims.start(rooms.patient)
    claims.renew()  # the network is back
    assert claims.trouble == ""
    assert [claim.station for claim in rooms.catalogues[1].claims()] == ["room-1"]
    claims.close()
