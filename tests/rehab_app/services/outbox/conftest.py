"""A station whose catalogue can be taken away and come back."""

from __future__ import annotations

import threading
from contextlib import contextmanager

import pytest

from rehab_app.access import CONSOLE
from rehab_app.bootstrap import open_clinic
from rehab_app.config import Settings
from rehab_app.errors import NoAnswer
from sessions.catalogue import (
    AssistanceMemory,
    AuditFilter,
    DayLimits,
    TherapySession,
)
from tests.postgres_server import server

LIMITS = DayLimits(
    patient="P-0001",
    side="left",
    device="sim",
    wrist_rad=0.0,
    content="wide",
    measured_utc_ns=1000,
    expires_utc_ns=9000,
    by="anna",
)
MEMORY = AssistanceMemory(patient="P-0001", exercise="pinch", device="sim", content="more", session="")
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
