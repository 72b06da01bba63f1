"""What is written about a patient, through the real command line."""

from __future__ import annotations

import json
import math

import pytest
from typer.testing import CliRunner

from rehab_app.cli.app import app


def invoke(data, *arguments):
    return CliRunner().invoke(app, [*(str(item) for item in arguments), "--data", str(data), "--json"])


def run(data, *arguments):
    result = invoke(data, *arguments)
    assert result.exit_code == 0, result.output
    return json.loads(result.stdout)


def refused(data, *arguments):
    result = invoke(data, *arguments)
    assert result.exit_code == 1, result.output
    assert "Traceback" not in result.output
    error = json.loads(result.stdout)["error"]
    assert all(error[key] for key in ("thing", "value", "bound", "remedy"))
    return error["message"]


@pytest.fixture
def data(tmp_path):
    person = ("--given", "Zoë", "--family", "Łuczak", "--birth-date", "1950-12-31", "--side", "left")
    run(tmp_path, "patient", "add", *person)
    return tmp_path


def test_patients_are_found_archived_and_brought_back(data):
    assert run(data, "patient", "find", "luczak 31.12.1950")["total"] == 1
    assert run(data, "patient", "archive", "P-0001", "--by", "anna")["archived"]
    assert run(data, "patient", "find")["total"] == 0
    assert run(data, "patient", "find", "--archived")["patients"][0]["family_name"] == "Łuczak"
    assert not run(data, "patient", "archive", "P-0001", "--back")["archived"]


def test_the_journal_is_written_corrected_and_listed(data):
    note = run(data, "patient", "note", "P-0001", "hand warm", "--by", "anna")
    pain = run(data, "patient", "pain", "P-0001", "--score", 6, "--place", "thumb", "--when", "rest")
    run(data, "patient", "pain", "P-0001", "--score", 4, "--corrects", pain["id"])
    event = ("--happened", "red skin", "--done", "pad", "--severity", "mild")
    run(data, "patient", "event", "P-0001", *event)
    kept = run(data, "patient", "journal", "P-0001")["entries"]
    assert [one["kind"] for one in kept] == ["adverse-event", "pain", "pain", "note"]
    assert (note["by"], note["what"]) == ("anna", {"text": "hand warm"})
    assert (kept[2]["corrected_by"], kept[1]["corrects"]) == (kept[1]["id"], pain["id"])
    assert "0 (none) to 10 (worst)" in refused(data, "patient", "pain", "P-0001", "--score", 11)
    assert "corrected already" in refused(
        data, "patient", "pain", "P-0001", "--score", 1, "--corrects", pain["id"]
    )
    assert "P-0002" in refused(data, "patient", "note", "P-0002", "x")


def test_outcomes_are_typed_as_read_and_kept_in_si(data):
    where = ("--side", "left", "--place", "wrist")
    typed = run(data, "patient", "outcome", "add", "P-0001", "tardieu-r1", "30,5", *where)
    assert typed["value"] == pytest.approx(math.radians(30.5))
    for day, score in (("2026-01-01", 10), ("2026-02-01", 16)):
        run(data, "patient", "outcome", "add", "P-0001", "arat", score, "--side", "left", "--date", day)
    arat, tardieu = run(data, "patient", "outcome", "list", "P-0001")["series"]
    assert (arat["change"], arat["direction"], arat["meaning"]) == (6.0, "better", "may matter")
    assert (tardieu["unit"], tardieu["change"], tardieu["place"]) == ("rad", None, "wrist")
    assert "0 to 57" in refused(data, "patient", "outcome", "add", "P-0001", "arat", 58, "--side", "left")
    assert "left or right" in refused(data, "patient", "outcome", "add", "P-0001", "arat", 5)
    rows = {row["key"]: row for row in run(data, "patient", "outcome", "measures")["measures"]}
    assert rows["grip"]["mcid"] == [5.0, 6.2]
