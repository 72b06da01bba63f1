"""Hazard 25: the disk is full in the middle of therapy: nobody records, and the hand must not go on alone."""

from __future__ import annotations

import resource
from contextlib import contextmanager

import pytest

from rehab_app.access import CONSOLE
from rehab_app.bootstrap import open_clinic
from rehab_app.errors import Refused
from rehab_app.services.order import Order
from robot_iface.link import MotionClient
from sessions.store import partials, verify

ROOM_BYTES = 200_000
"""Beyond the largest file that is there: the data base can still be written, a session soon cannot."""


@contextmanager
def full_disk(folder):
    """No file grows beyond the bound, as on a disk without room."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    largest = max(path.stat().st_size for path in folder.rglob("*") if path.is_file())
    resource.setrlimit(resource.RLIMIT_FSIZE, (largest + ROOM_BYTES, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


def test_the_hand_is_braked_the_recording_kept_and_the_next_run_plays(tmp_path):
    with open_clinic(tmp_path / "clinic") as clinic:
        clinic.takes.record_virtual("open_close", "right", 4.0, 4, CONSOLE)
        take = clinic.takes.list()[0].id
        clinic.takes.approve(take, CONSOLE)
        plan = clinic.therapy.plan(take, Order(repetitions=2, speed=1.0), actor=CONSOLE)
        with MotionClient() as client:
            certificate = clinic.therapy.rehearse(plan, actor=CONSOLE, client=client)
            with full_disk(clinic.folder), pytest.raises(Refused, match="not writable"):
                clinic.therapy.play(plan, certificate, actor=CONSOLE, client=client)
        assert client._process.returncode == 0, "the motion process did not brake and end by itself"
        assert clinic.sessions.list() == ()
        (restored,) = clinic.interrupted.restore()
        assert restored.trouble == ""
        verify(clinic.sessions.get(restored.id).path)
        assert not partials(clinic.folder / "sessions")
        played = clinic.therapy.rehearse_and_play(plan, actor=CONSOLE)
        assert played.completed
