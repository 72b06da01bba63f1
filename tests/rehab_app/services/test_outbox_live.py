"""What runs when the data base goes away runs on, is sealed, and can be stopped: a real server, real time."""

from __future__ import annotations

import threading
import time
from contextlib import contextmanager

import pytest

from rehab_app.access import CONSOLE
from rehab_app.bootstrap import open_clinic
from rehab_app.config import Settings
from rehab_app.errors import NoAnswer
from rehab_app.services.order import Order
from rehab_app.services.outbox_memory import RememberingCatalogue
from rehab_app.services.recording_request import RecordingRequest
from rehab_app.services.take_sources import Listeners
from sessions.catalogue import Catalogue
from sessions.records.topics import EVENTS
from sessions.store import SessionReader, verify
from tests.postgres_server import server

PATIENCE_S = 60.0
PATIENT = "P-0001"


@pytest.fixture
def room(tmp_path, take_file):
    settings = Settings(catalogue_url=server().fresh(), station="room")
    with open_clinic(tmp_path / "room", settings=settings) as clinic:
        clinic.takes.approve(clinic.takes.get(take_file).id, CONSOLE)
        for name in ("Ida", "Ugo"):
            clinic.patients.add(
                CONSOLE, given_name=name, family_name="Berg", birth_date="1957-03-14", side="right"
            )
        yield clinic


def until(desk, wanted):
    end, pause = time.monotonic() + PATIENCE_S, threading.Event()
    while time.monotonic() < end:
        snapshot = desk.snapshot()
        if wanted(snapshot):
            return snapshot
        assert snapshot.state != "failed", snapshot.message
        desk.operator_beat()
        pause.wait(0.01)
    raise AssertionError(f"never came: {desk.snapshot()}")


def moving(snapshot):
    return (
        snapshot.state == "playing" and snapshot.phase == "move" and snapshot.patient_joints_rad is not None
    )


def causes(path):
    with SessionReader(path) as reader:
        return [event.cause for event in reader.records(EVENTS)]


def test_therapy_is_finished_sealed_and_entered_later(room):
    desk, take = room.live, room.takes.list()[0].id
    desk.start_therapy(CONSOLE, PATIENT, take, Order(speed=1.0, repetitions=1))
    until(desk, moving)
    server().stop()
    try:
        done = until(desk, lambda one: one.state == "done")
        assert done.message == "The session is recorded."
        row = room.catalogue.session(done.session_id)
        sealed = room.folder / row.path
        assert verify(sealed).sha256 == row.sha256
        assert not {"hold", "e-stop", "watchdog"} & set(causes(sealed))
        assert room.outbox.state().waiting > 0
        desk.close()
        with pytest.raises(NoAnswer):  # who may be in therapy elsewhere
            desk.start_therapy(CONSOLE, "P-0002", take, Order(repetitions=1))
    finally:
        server().start()
    room.outbox.bring()
    assert [(one.patient, one.sha256) for one in room.catalogue.sessions()] == [(PATIENT, row.sha256)]
    room.catalogue.verify_audit()
    assert room.outbox.state().waiting == 0


def test_nothing_that_moves_or_stops_waits_for_the_catalogue(room, monkeypatch):
    """From the first movement on the catalogue answers nobody: not even with a refusal."""
    desk, take, answered = room.live, room.takes.list()[0].id, threading.Event()
    inner = RememberingCatalogue._answering

    @contextmanager
    def held_up(self):
        answered.wait(PATIENCE_S)
        with inner(self):
            yield

    desk.start_therapy(CONSOLE, PATIENT, take, Order(speed=0.5, repetitions=20))
    first = until(desk, moving)
    monkeypatch.setattr(RememberingCatalogue, "_answering", held_up)
    try:
        until(desk, lambda one: one.frame > first.frame + 60)
        desk.controls.pause(CONSOLE)
        until(desk, lambda one: one.paused)
        desk.controls.resume(CONSOLE)
        until(desk, lambda one: one.safety_state == "ACTIVE" and not one.paused)
        desk.press_stop("key")
        assert desk.snapshot().stop_source == "key"
        until(
            desk, lambda _: desk._job is None or desk._job._client.live().safety_state.name.startswith("CAT")
        )
    finally:
        answered.set()
    until(desk, lambda _: room.catalogue.sessions())
    (row,) = room.catalogue.sessions()
    assert [cause for cause in causes(room.folder / row.path) if cause == "e-stop"] == ["e-stop"]


def test_a_recording_is_finished_sealed_and_entered_later(room):
    seen = []

    def watch(live):
        seen.append(live)
        if len(seen) == 20:
            server().stop()

    request = RecordingRequest(exercise="open_close", side="right", seconds=2.5, seed=5)
    try:
        summary = room.takes.record(
            request, CONSOLE, listeners=Listeners(watch, lambda _: None, lambda: False)
        )
        assert len(seen) > 20
        kept = room.takes.get(summary.take)
        assert verify(kept.path).sha256 == kept.sha256
        assert room.outbox.state().waiting > 0
    finally:
        server().start()
    room.outbox.bring()
    with Catalogue.open(room.folder, room.settings.catalogue_url) as plain:
        assert plain.take(summary.take).sha256 == kept.sha256
