"""Stations and claims of patients, over every engine a catalogue may stand on."""

from __future__ import annotations

import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from sessions.catalogue import Catalogue, Patient, PatientClaim, Station
from sessions.catalogue.stations import FORGOTTEN_NS
from sessions.errors import Refused
from tests.contracts.test_catalogue import catalogue, url

__all__ = ["catalogue", "url"]

LONG_NS = 3600 * 1_000_000_000
STATIONS = ("room-1", "room-2")


@pytest.fixture
def patient(catalogue: Catalogue) -> str:
    return catalogue.add_patient(Patient(side="right")).id


def test_a_patient_is_claimed_renewed_and_released_by_one_holder(catalogue: Catalogue, patient: str) -> None:
    first, taken = catalogue.claim_patient(patient, "room-1", "a", LONG_NS)
    assert taken is None
    assert catalogue.claims() == (first,)
    again, taken = catalogue.claim_patient(patient, "room-1", "a", 2 * LONG_NS)
    assert taken is None
    assert again.since_utc_ns == first.since_utc_ns
    assert again.until_utc_ns > first.until_utc_ns
    catalogue.release_patient(patient, "b")
    assert catalogue.claims() == (again,)
    catalogue.release_patient(patient, "a")
    assert catalogue.claims() == ()


def test_another_station_is_told_where_and_since_when(catalogue: Catalogue, patient: str) -> None:
    claim, _ = catalogue.claim_patient(patient, "room-1", "a", LONG_NS)
    since = time.strftime("%H:%M:%S", time.localtime(claim.since_utc_ns // 10**9))
    for station in STATIONS:  # a process of the same name is another holder, too
        with pytest.raises(Refused, match=f"{patient} is in therapy at station room-1 since {since}") as told:
            catalogue.claim_patient(patient, station, "b", LONG_NS)
        assert "\n" not in str(told.value)
    other = catalogue.add_patient(Patient(side="left")).id
    catalogue.claim_patient(other, "room-2", "b", LONG_NS)
    assert [one.station for one in catalogue.claims()] == ["room-1", "room-2"]
    with pytest.raises(Refused, match="P-9999"):
        catalogue.claim_patient("P-9999", "room-1", "a", LONG_NS)


def test_a_holder_that_is_known_to_have_died_binds_nobody(catalogue: Catalogue, patient: str) -> None:
    catalogue.claim_patient(patient, "room-1", "a", LONG_NS)
    with pytest.raises(Refused, match="in therapy at station room-1"):
        catalogue.claim_patient(patient, "room-1", "b", LONG_NS, {"c"})
    mine, taken = catalogue.claim_patient(patient, "room-1", "b", LONG_NS, {"a", "c"})
    assert taken is not None
    assert (mine.holder, taken.holder) == ("b", "a")


def test_a_claim_that_ran_out_is_taken_over_and_told(catalogue: Catalogue, patient: str) -> None:
    dead, _ = catalogue.claim_patient(patient, "room-1", "a", 0)
    assert catalogue.claims() == ()
    mine, taken = catalogue.claim_patient(patient, "room-2", "b", LONG_NS)
    assert taken == dead
    assert mine.station == "room-2"
    assert mine.since_utc_ns >= dead.until_utc_ns
    catalogue.release_patient(patient, "a")  # the dead one comes back late
    assert catalogue.claims() == (mine,)
    with pytest.raises(Refused, match="room-2"):
        catalogue.claim_patient(patient, "room-1", "a", LONG_NS)


def test_of_two_stations_at_once_exactly_one_wins(url: str, tmp_path: Path) -> None:
    gate = threading.Barrier(2)

    def claim(opened: Catalogue, station: str, patient: str) -> PatientClaim | str:
        gate.wait()
        try:
            return opened.claim_patient(patient, station, station, LONG_NS)[0]
        except Refused as refusal:
            return str(refusal)

    with (
        Catalogue.open(tmp_path, url) as one,
        Catalogue.open(tmp_path, url) as two,
        ThreadPoolExecutor(2) as pool,
    ):
        for _ in range(12):
            patient = one.add_patient(Patient(side="right")).id
            asked = zip((one, two), STATIONS, strict=True)
            results = [pool.submit(claim, opened, station, patient) for opened, station in asked]
            outcomes = [result.result() for result in results]
            (winner,) = [outcome for outcome in outcomes if isinstance(outcome, PatientClaim)]
            (told,) = [outcome for outcome in outcomes if isinstance(outcome, str)]
            assert f"at station {winner.station} since" in told
            assert winner in two.claims()


def test_stations_say_themselves(catalogue: Catalogue) -> None:
    said = Station(name="room-1", holder="a", version="1.0", offset_ns=-3, uncertainty_ns=2)
    assert catalogue.say_station(said) is None
    (first,) = catalogue.stations()
    assert (first.offset_ns, first.uncertainty_ns, first.version) == (-3, 2, "1.0")
    before = catalogue.say_station(Station(name="room-1", holder="b", version="1.1"))
    assert before == first
    catalogue.say_station(Station(name="room-0", holder="c", version="1.1"))
    assert [one.name for one in catalogue.stations()] == ["room-0", "room-1"]
    newest = catalogue.stations()[1]
    assert (newest.holder, newest.version) == ("b", "1.1")
    assert first.seen_utc_ns < newest.seen_utc_ns <= catalogue.data_base_time_ns()


def test_a_station_that_was_silent_for_long_is_forgotten(tmp_path: Path) -> None:
    now_ns = [10**18]
    with Catalogue.open(tmp_path, "", lambda: now_ns[0]) as catalogue:
        catalogue.say_station(Station(name="old", holder="a", version="1"))
        now_ns[0] += FORGOTTEN_NS
        catalogue.say_station(Station(name="new", holder="b", version="1"))
        assert [one.name for one in catalogue.stations()] == ["new", "old"]
        now_ns[0] += 1
        catalogue.say_station(Station(name="new", holder="b", version="1"))
        assert [one.name for one in catalogue.stations()] == ["new"]


def test_the_clock_of_a_server_is_asked_and_that_of_a_file_is_ours(catalogue: Catalogue, url: str) -> None:
    trips = catalogue.clock_trips(5)
    if url.startswith("sqlite"):
        assert trips == ()
        return
    assert len(trips) == 5
    for trip in trips:  # the server of the tests runs on this machine: one clock, read to the microsecond
        assert trip.trip_ns > 0
        assert -2000 <= trip.there_utc_ns - trip.asked_utc_ns <= trip.trip_ns + 2000


def test_erasure_takes_the_claim_along(catalogue: Catalogue, patient: str) -> None:
    other = catalogue.add_patient(Patient(side="left")).id
    catalogue.claim_patient(patient, "room-1", "a", LONG_NS)
    catalogue.claim_patient(other, "room-1", "a", LONG_NS)
    assert [row["station"] for row in catalogue.patient_rows(patient)["patient_claims"]] == ["room-1"]
    catalogue.erase_patient(patient, "[]", "anna")
    assert [claim.patient for claim in catalogue.claims()] == [other]
    assert catalogue.patient_rows(patient)["patient_claims"] == []


def test_stations_and_claims_are_copied_with_everything_else(
    catalogue: Catalogue, patient: str, tmp_path: Path
) -> None:
    catalogue.claim_patient(patient, "room-1", "a", LONG_NS)
    catalogue.say_station(Station(name="room-1", holder="a", version="1"))
    (tmp_path / "copy").mkdir()
    catalogue.copy_to(tmp_path / "copy" / "clinic.sqlite3")
    with Catalogue.open(tmp_path / "copy", "", lambda: 0) as copy:
        assert copy.stations() == catalogue.stations()
        assert copy.claims() == catalogue.claims()
