"""What stations say of themselves, and how far their clocks are off."""

from __future__ import annotations

import shutil
import threading
from dataclasses import replace
from pathlib import Path

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rehab_app.access import CONSOLE, Account
from rehab_app.bootstrap import open_clinic
from rehab_app.cli.doctor import examine
from rehab_app.config import ClinicFolder, Settings
from rehab_app.errors import Refused
from rehab_app.services.station_clock import ClockOffset, clock_warning, offset_of, offset_words
from sessions.catalogue import Catalogue, ClockTrip, Patient, Station
from sessions.store import SessionReader
from tests.contracts.test_catalogue import URLS

PATIENT = Account("p", "patient", "9")
WAYS_NS = st.tuples(st.integers(0, 10**8), st.integers(0, 10**8))


@given(
    offset_ns=st.integers(-(10**13), 10**13),
    ways=st.lists(WAYS_NS, min_size=1, max_size=8),
    now_ns=st.integers(10**18, 2 * 10**18),
)
def test_the_true_offset_lies_within_the_uncertainty(offset_ns, ways, now_ns):
    """However unequal the ways there and back are."""
    trips = [ClockTrip(now_ns, now_ns + there - offset_ns, there + back) for there, back in ways]
    found = offset_of(trips)
    assert abs(found.offset_ns - offset_ns) <= found.uncertainty_ns
    assert found.uncertainty_ns == (min(there + back for there, back in ways) + 1) // 2


def test_the_clock_of_a_file_of_this_machine_is_ours():
    assert offset_of(()) == ClockOffset(0, 0)
    assert offset_words(ClockOffset(0, 0)) == "the data base's own"
    assert offset_words(ClockOffset(-1_500_000, 200_000)) == "-1.5 ± 0.2 ms off the data base's"


@given(offset_ns=st.integers(-(10**11), 10**11), uncertainty_ns=st.integers(0, 10**10))
def test_more_than_two_seconds_for_certain_are_warned_of(offset_ns, uncertainty_ns):
    warning = clock_warning("room-1", ClockOffset(offset_ns, uncertainty_ns))
    assert bool(warning) == (abs(offset_ns) - uncertainty_ns > 2 * 10**9)
    if warning:
        assert "room-1" in warning
        assert ("ahead of" in warning) == (offset_ns > 0)


@pytest.fixture(params=sorted(URLS))
def rooms(request, tmp_path):
    """Two stations with folders of their own on one data base."""
    url = URLS[request.param](tmp_path)
    names = ("room-1", "room-2")
    opened = [
        open_clinic(tmp_path / name, settings=Settings(catalogue_url=url, station=name)) for name in names
    ]
    yield opened
    for clinic in opened:
        clinic.close()


def off_by(monkeypatch, offset_ns, uncertainty_ns=1000):
    """Let the data base's clock be off by so much."""

    def trips(_catalogue, count):
        return (ClockTrip(10**18, 10**18 - offset_ns + uncertainty_ns, 2 * uncertainty_ns),) * count

    monkeypatch.setattr(Catalogue, "clock_trips", trips)


def test_each_says_itself_and_sees_the_other(rooms):
    one, two = rooms
    one.stations.say()
    two.stations.say()
    patient = one.catalogue.add_patient(Patient(side="right")).id
    one.catalogue.claim_patient(patient, "room-1", "a", 10**12)
    seen = two.stations.list(CONSOLE)
    assert [state.station.name for state in seen] == ["room-1", "room-2"]
    assert [state.here for state in seen] == [False, True]
    assert [[claim.patient for claim in state.patients] for state in seen] == [[patient], []]
    assert not any(state.silent or state.warning for state in seen)
    assert {state.station.version for state in seen} == {one.version}
    assert one.stations.trouble == two.stations.trouble == ""
    with pytest.raises(Refused, match="patient"):
        one.stations.list(PATIENT)


def test_a_clock_that_is_off_is_warned_of_everywhere(rooms, monkeypatch, tmp_path):
    one, two = rooms
    with monkeypatch.context() as wrong:
        off_by(wrong, 3_250_000_000)
        one.stations.say()
    two.stations.say()
    assert "room-1 is 3.2 s ahead of the data base's" in one.stations.trouble
    first, second = two.stations.list(CONSOLE)
    assert first.clock == ClockOffset(3_250_000_000, 1000)
    assert first.warning == one.stations.trouble
    assert second.warning == ""
    (tmp_path / "room-2" / "rehab-app.toml").write_text(
        f'station = "room-2"\ncatalogue_url = "{two.settings.catalogue_url}"\n'
    )
    found = [one for one in examine(ClinicFolder(tmp_path / "room-2"), 1) if one.name == "stations"]
    assert [one.ok for one in found] == [True, False]
    assert "ahead of" in found[1].remedy


def test_two_machines_of_one_name_are_told(rooms):
    one, two = rooms
    one.stations.say()
    two.catalogue.say_station(Station(name="room-1", holder="another", version="1"))
    one.stations.say()
    assert "Another machine calls itself station room-1" in one.stations.trouble
    one.stations.say()
    assert one.stations.trouble == ""


def test_a_silent_station_is_shown_as_such(rooms, monkeypatch):
    one, two = rooms
    one.stations.say()
    said_ns = one.catalogue.stations()[0].seen_utc_ns
    for after_s in (90, 91):
        monkeypatch.setattr(Catalogue, "data_base_time_ns", lambda _, t=said_ns + after_s * 10**9: t)
        (seen,) = two.stations.list(CONSOLE)
        assert (seen.silent_s, seen.silent) == (after_s, after_s > 90)


def test_the_stamp_of_a_session_says_where_and_how_the_clock_stood(rooms, monkeypatch):
    one, two = rooms
    off_by(monkeypatch, -5_000_000)
    assert msgspec.json.decode(one.stations.stamp()) == {
        "name": "room-1",
        "clock_offset_ns": -5_000_000,
        "clock_uncertainty_ns": 1000,
    }

    def gone(_catalogue, _count):
        raise Refused("clinic data base", "not answering", "one that answers", "check the network")

    monkeypatch.setattr(Catalogue, "clock_trips", gone)
    assert "-5000000" in one.stations.stamp()  # as it stood last
    unknown = msgspec.json.decode(two.stations.stamp())
    assert (unknown["clock_offset_ns"], unknown["clock_uncertainty_ns"]) == (None, None)


def test_a_server_says_itself_from_its_start_on(tmp_path, monkeypatch):
    said = threading.Event()
    say = Catalogue.say_station

    def saying(catalogue, station):
        before = say(catalogue, station)
        said.set()
        return before

    monkeypatch.setattr(Catalogue, "say_station", saying)
    with open_clinic(tmp_path / "c", serving=True, settings=Settings(station="room-7")) as clinic:
        assert said.wait(30.0)
        (seen,) = clinic.stations.list(CONSOLE)
        assert seen.here
        assert seen.station.name == "room-7"


def test_looking_makes_and_migrates_nothing(tmp_path: Path):
    assert Catalogue.look(tmp_path / "none") is None
    assert not (tmp_path / "none").exists()
    (tmp_path / "empty").mkdir()
    (tmp_path / "empty" / "clinic.sqlite3").write_bytes(b"")
    assert Catalogue.look(tmp_path / "empty") is None
    assert [one for one in examine(ClinicFolder(tmp_path / "empty"), 1) if one.name == "stations"] == []
    Catalogue.open(tmp_path / "full").close()
    looked = Catalogue.look(tmp_path / "full")
    assert looked is not None
    with looked:
        assert looked.stations() == ()
    shutil.rmtree(tmp_path / "full")


def test_a_data_base_that_is_away_is_a_finding(tmp_path: Path):
    (tmp_path / "rehab-app.toml").write_text('catalogue_url = "postgresql://clinic:x@127.0.0.1:1/clinic"\n')
    (found,) = [one for one in examine(ClinicFolder(tmp_path), 1) if one.name == "stations"]
    assert not found.ok
    assert "not answering" in found.found


def test_a_long_host_name_is_cut(tmp_path, monkeypatch):
    monkeypatch.setattr("socket.gethostname", lambda: "h" * 64)
    with open_clinic(tmp_path, settings=replace(Settings(), station="")) as clinic:
        assert clinic.stations.name == "h" * 63


def test_a_recorded_take_says_where_it_was_recorded(tmp_path):
    with open_clinic(tmp_path, settings=Settings(station="room-3")) as clinic:
        take = clinic.takes.record_virtual("open_close", "right", 1.5, 3, CONSOLE)
        with SessionReader(clinic.takes.get(take.take).path) as reader:
            stamp = msgspec.json.decode(reader.header.station)
    assert stamp == {"name": "room-3", "clock_offset_ns": 0, "clock_uncertainty_ns": 0}
