"""The page of stations: who is heard, whose clock is off, who is in therapy where."""

from __future__ import annotations

import pytest

from sessions.catalogue import Station


@pytest.fixture
def stations(clinic, patient):
    """Another room with a patient in therapy and a clock that is off."""
    clinic.stations.say()
    off = Station(
        name="room-2", holder="b", version="0.0.9", offset_ns=-3_210_000_000, uncertainty_ns=400_000
    )
    clinic.catalogue.say_station(off)
    clinic.catalogue.claim_patient(patient, "room-2", "b", 10**12)
    yield clinic
    clinic.catalogue.release_patient(patient, "b")


@pytest.mark.parametrize("role", ["administrator", "therapist", "assistant", "auditor"])
def test_everybody_who_may_look_sees_the_stations(browser, role, stations, patient):
    shown = browser(role).get("/clinic/stations")
    assert shown.status_code == 200
    for words in (
        stations.stations.name,
        "this one",
        "room-2",
        "0.0.9",
        "The clock of station room-2 is 3.2 s behind the data base",
        "-3210.0 ± 0.4 ms",
        f'href="/patients/{patient}"',
    ):
        assert words in shown.text


def test_a_patients_screen_does_not(browser, stations):
    assert browser("patient").get("/clinic/stations").status_code == 403


def test_the_clinic_leads_there(browser):
    assert 'href="/clinic/stations"' in browser("auditor").get("/clinic").text
