"""The library, plans and withdrawals through the real command line."""

from __future__ import annotations

import json

import pytest
from typer.testing import CliRunner

from rehab_app.access import CONSOLE
from rehab_app.bootstrap import open_clinic
from rehab_app.cli.app import app
from rehab_app.services.plan_items import Plan, PlanItem


def invoke(data, *arguments):
    return CliRunner().invoke(app, [*(str(item) for item in arguments), "--data", str(data), "--json"])


def run(data, *arguments):
    result = invoke(data, *arguments)
    assert result.exit_code == 0, result.output
    return json.loads(result.stdout)


def refused(data, *arguments):
    result = invoke(data, *arguments)
    assert result.exit_code == 1, result.output
    error = json.loads(result.stdout)["error"]
    assert all(error[key] for key in ("thing", "value", "bound", "remedy"))
    return error


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    folder = tmp_path_factory.mktemp("clinic")
    with open_clinic(folder) as clinic:
        clinic.patients.add(
            CONSOLE, given_name="Ada", family_name="Lovelace", birth_date="1950-12-31", side="left"
        )
        clinic.plans.change(
            CONSOLE, Plan(patient="P-0001", items=(PlanItem(exercise="wave"),), reason="first")
        )
        take = clinic.takes.record_virtual("pinch", "right", 1.5, 1, CONSOLE).take
        clinic.takes.approve(take, CONSOLE)
    return folder


def test_the_library_is_listed_and_searched(data):
    assert len(run(data, "exercise", "list")["exercises"]) >= 19
    assert [row["name"] for row in run(data, "exercise", "list", "hook")["exercises"]] == ["hook_fist"]
    assert refused(data, "exercise", "list", "--purpose", "fun")["thing"] == "purpose"


def test_an_exercise_is_shown_and_drawn(data, tmp_path):
    out = tmp_path / "wave.svg"
    shown = run(data, "exercise", "show", "wave", "--out", out, "--side", "left")
    assert (shown["words"], shown["picture"]) == ("Wave", str(out))
    assert out.read_text().startswith("<svg")
    assert refused(data, "exercise", "show", "juggling")["thing"] == "exercise"
    assert refused(data, "exercise", "show", "wave", "--out", tmp_path / "wave.png")["thing"] == "--out"
    assert refused(data, "exercise", "show", "wave", "--out", tmp_path / "a.svg", "--view", "top")["thing"]
    assert list(tmp_path.iterdir()) == [out]


def test_an_own_exercise_is_added(data):
    added = run(data, "exercise", "add", "Towel", "--description", "Wring it.")
    assert (added["name"], added["own"]) == ("Towel", True)
    assert refused(data, "exercise", "add", "Wave", "--description", "x")["thing"] == "name of the exercise"


def test_a_plan_is_shown_with_what_is_missing(data):
    shown = run(data, "patient", "plan", "show", "P-0001")
    assert [item["exercise"] for item in shown["plan"]["items"]] == ["wave"]
    assert "no approved take" in shown["notes"][0]
    assert [one["reason"] for one in shown["versions"]] == ["first"]
    assert refused(data, "patient", "plan", "show", "P-0777")


def test_an_approval_is_withdrawn(data):
    with open_clinic(data) as clinic:
        take = clinic.takes.list()[0].id
    assert run(data, "withdraw", take, "--reason", "hidden thumb")["take"] == take
    assert refused(data, "play", take)["value"] == "not approved"
    assert refused(data, "withdraw", take, "--reason", "again")["value"] == "not approved"
