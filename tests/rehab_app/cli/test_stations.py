"""stations through the real command line."""

from __future__ import annotations

import json

from typer.testing import CliRunner

from rehab_app.bootstrap import open_clinic
from rehab_app.cli.app import app
from sessions.catalogue import Patient, Station


def run(folder, *arguments):
    return CliRunner().invoke(app, ["stations", "--data", str(folder), *arguments])


def test_nobody_has_spoken_yet(tmp_path):
    told = run(tmp_path, "--json")
    assert told.exit_code == 0, told.output
    assert json.loads(told.stdout)["stations"] == []
    assert "a station speaks while it serves" in told.stderr


def test_stations_are_listed_with_their_clocks_and_patients(tmp_path, monkeypatch):
    monkeypatch.setenv("REHAB_STATION", "room-1")
    with open_clinic(tmp_path) as clinic:
        patient = clinic.catalogue.add_patient(Patient(side="right")).id
        clinic.stations.say()
        off = Station(name="room-2", holder="b", version="9", offset_ns=2_500_000_000, uncertainty_ns=1)
        clinic.catalogue.say_station(off)
        clinic.catalogue.claim_patient(patient, "room-2", "b", 10**12)
    told = run(tmp_path, "--json")
    content = json.loads(told.stdout)
    assert content["here"] == {"name": "room-1", "offset_ns": 0, "uncertainty_ns": 0}
    first, second = content["stations"]
    assert (first["here"], first["patients"], first["warning"]) == (True, [], "")
    assert [claim["patient"] for claim in second["patients"]] == [patient]
    assert "holder" not in second
    lines = told.stderr.splitlines()
    assert lines[0].startswith("room-1 (here): heard")
    assert lines[1].endswith(f"in therapy: {patient}")
    assert "room-2 is 2.5 s ahead" in lines[2]
