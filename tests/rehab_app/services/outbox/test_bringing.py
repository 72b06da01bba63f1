"""The server brings what waited by itself, and waits for nobody who does not answer."""

from __future__ import annotations

import os
import signal
import socket
import threading

import pytest

from rehab_app.access import CONSOLE
from rehab_app.bootstrap import open_clinic
from rehab_app.cli.doctor import examine
from rehab_app.config import ClinicFolder, Settings
from rehab_app.errors import NoAnswer
from rehab_app.services.left_over import unentered
from rehab_app.services.outbox_catalogue import open_catalogue
from sessions.catalogue import (
    Catalogue,
    Patient,
)
from tests.postgres_server import server

from .conftest import away, details, session


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
