"""Two stations on one PostgreSQL catalogue: a patient is in therapy at one of them."""

from __future__ import annotations

import json
import shutil
import threading
import time

import pytest

from rehab_app.access import CONSOLE
from rehab_app.bootstrap import open_clinic
from rehab_app.config import Settings
from rehab_app.errors import Refused
from rehab_app.services.order import Order
from sessions.catalogue import Catalogue, Patient
from sessions.store import SessionReader
from tests.postgres_server import server

PATIENCE_S = 180.0
LONG = Order(speed=0.5, repetitions=20)
SHORT = Order(speed=1.0, repetitions=1)


@pytest.fixture
def rooms(tmp_path, take_file):
    """Two clinics, each with a folder of its own and the same approved take in it."""
    url = server().fresh()
    opened = [
        open_clinic(tmp_path / name, settings=Settings(catalogue_url=url, station=name))
        for name in ("room-1", "room-2")
    ]
    one, two = opened
    one.takes.approve(one.takes.get(take_file).id, CONSOLE)
    (held,) = one.catalogue.takes()
    for suffix in ("", ".sha256"):
        shutil.copyfile(f"{one.folder / held.path}{suffix}", f"{two.folder / held.path}{suffix}")
    yield opened
    for clinic in opened:
        clinic.close()


@pytest.fixture
def patient(rooms):
    return rooms[0].catalogue.add_patient(Patient(side="right", hand_length_m=0.185)).id


def begin(clinic, patient, order):
    clinic.live.start_therapy(CONSOLE, patient, clinic.takes.list()[0].id, order)


def until(clinic, wanted):
    end_s, pause = time.monotonic() + PATIENCE_S, threading.Event()
    while not wanted(clinic.live.snapshot()):
        assert time.monotonic() < end_s, f"never came: {clinic.live.snapshot()}"
        clinic.live.operator_beat()
        pause.wait(0.01)
    return clinic.live.snapshot()


def test_a_patient_is_in_therapy_at_one_station_only(rooms, patient):
    one, two = rooms
    one.stations.say()
    begin(one, patient, SHORT)
    for start in (
        lambda: begin(two, patient, SHORT),
        lambda: two.live.start_assessment(CONSOLE, "range", patient, SHORT),
    ):
        with pytest.raises(Refused, match=f"patient {patient} is in therapy at station room-1 since"):
            start()
    assert two.live.snapshot().state == "idle"
    done = until(one, lambda shown: shown.state == "done")
    with SessionReader(one.sessions.get(done.session_id).path) as reader:
        stamp = json.loads(reader.header.station)
    assert stamp["name"] == "room-1"
    assert abs(stamp["clock_offset_ns"]) <= stamp["clock_uncertainty_ns"] + 10**6  # one clock, in truth
    until(one, lambda _: not two.catalogue.claims())
    begin(two, patient, LONG)
    assert [claim.station for claim in one.catalogue.claims()] == ["room-2"]
    two.live.press_stop("end of test")
    until(two, lambda _: not one.catalogue.claims())


def test_a_start_that_is_stopped_sets_the_patient_free(rooms, patient):
    one, two = rooms
    begin(one, patient, LONG)
    one.live.press_stop("changed our mind")
    until(one, lambda _: not two.catalogue.claims())
    begin(two, patient, SHORT)
    two.live.press_stop("end of test")


def test_the_hand_moves_on_when_the_claim_cannot_be_renewed(rooms, patient, monkeypatch):
    """The other station took the patient over while the network was away; therapy here is not touched."""
    one, _ = rooms
    begin(one, patient, LONG)
    until(one, lambda shown: shown.state == "playing" and shown.phase == "move")

    def away(*_: object):
        raise Refused("clinic data base", "not answering", "one that answers", "check the network")

    monkeypatch.setattr(Catalogue, "claim_patient", away)
    claims = one.live._works._claims
    claims.renew()
    told = until(one, lambda shown: any("was not renewed" in note for note in shown.notes))
    later = until(one, lambda shown: shown.frame > told.frame + 30)
    assert later.state == "playing"
    assert later.safety_state == "ACTIVE"
    assert not later.paused
    one.live.press_stop("end of test")
    until(one, lambda shown: not one.live._thread.is_alive())
