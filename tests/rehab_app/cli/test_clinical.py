"""Clinical records and limits through the real command line."""

from __future__ import annotations

import json

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
    assert isinstance(result.exception, SystemExit), result.exception
    assert result.exit_code == 1, result.output
    assert "Traceback" not in result.output
    error = json.loads(result.stdout)["error"]
    assert all(error[key] for key in ("thing", "value", "bound", "remedy"))
    return error


@pytest.fixture
def data(tmp_path):
    person = ("--given", "Ada", "--family", "Lovelace", "--birth-date", "1950-12-31", "--side", "left")
    run(tmp_path, "patient", "add", *person)
    return tmp_path


def test_diagnoses_say_what_they_lock(tmp_path):
    rows = {row["key"]: row for row in run(tmp_path, "patient", "diagnoses")["diagnoses"]}
    assert rows["flexor-tendon-repair"]["locked_until_day"]["resistive"] == 56
    assert rows["crps"]["locked_until_day"]["passive"] is None
    assert rows["nerve-lesion"]["skin_check_s"] == 600.0


def test_a_record_is_stated_shown_and_unlocked(data):
    assert run(data, "patient", "show", "P-0001")["record"] is None
    bones = ",".join(["46", "36", "29"] + ["45", "26", "18"] * 4)
    stated = run(
        data, "patient", "record", "P-0001", "--diagnosis", "crps", "--mas", "1+", "--bones-mm", bones,
        "--event-date", "2026-01-02", "--unaware", "--by", "anna",
    )  # fmt: skip
    assert stated["record"]["by"] == "anna"
    assert stated["record"]["bones_m"][0] == pytest.approx([0.046, 0.036, 0.029])
    assert set(stated["locks"]) == {"passive", "resistive"}
    assert any("halved" in note for note in stated["notes"])
    given = run(data, "patient", "unlock", "P-0001", "--mode", "passive", "--reason", "quiet", "--by", "anna")
    assert given["unlocked"]
    assert set(run(data, "patient", "show", "P-0001")["locks"]) == {"resistive"}
    run(data, "patient", "lock", "P-0001", "--mode", "passive")
    assert set(run(data, "patient", "show", "P-0001")["locks"]) == {"passive", "resistive"}


@pytest.mark.parametrize(
    "options",
    [
        ("--diagnosis", "hangover"),
        ("--diagnosis", "stroke", "--mas", "7"),
        ("--diagnosis", "stroke", "--event-date", "yesterday"),
        ("--diagnosis", "stroke", "--event-date", "2190-01-01"),
        ("--diagnosis", "stroke", "--bones-mm", "1,2,3"),
        ("--diagnosis", "stroke", "--bones-mm", "a" * 40),
        ("--diagnosis", "stroke", "--bones-mm", ",".join(["nan"] * 15)),
    ],
)
def test_a_record_of_nonsense_is_refused(data, options):
    refused(data, "patient", "record", "P-0001", *options)
    assert run(data, "patient", "show", "P-0001")["record"] is None


def test_unknown_people_are_refused(data):
    for command in (
        ("patient", "show", "P-9999"),
        ("patient", "record", "P-9999", "--diagnosis", "none"),
        ("patient", "unlock", "P-9999", "--mode", "passive", "--reason", "x"),
        ("patient", "lock", "P-9999", "--mode", "passive"),
        ("limits", "show", "P-9999"),
        ("limits", "raise", "P-9999", "index_pip", "--nm", "0.2"),
        ("limits", "range", "P-9999", "index_pip", "--from", "0", "--to", "50"),
    ):
        assert "P-9999" in refused(data, *command)["thing"]


def test_limits_are_shown_raised_and_set(data):
    shown = run(data, "limits", "show", "P-0001")
    assert not shown["measured"]
    assert shown["joints"]["index_pip"]["tau_interaction_nm"] == pytest.approx(0.15)
    raised = run(data, "limits", "raise", "P-0001", "index_pip", "--nm", "0.3", "--reason", "stiff")
    assert raised["joints"]["index_pip"]["tau_interaction_nm"] == pytest.approx(0.3)
    set_ = run(data, "limits", "range", "P-0001", "index_pip", "--from", "10", "--to", "45")
    assert set_["joints"]["index_pip"]["q_max_rad"] == pytest.approx(0.7854, abs=1e-4)


@pytest.mark.parametrize("value", ["0.46", "-1", "nan", "inf", "0"])
def test_a_torque_of_nonsense_is_refused(data, value):
    refused(data, "limits", "raise", "P-0001", "index_pip", "--nm", value, "--reason", "x")


def test_other_nonsense_is_refused(data):
    for options in (
        ("raise", "P-0001", "index_toe", "--nm", "0.1"),
        ("raise", "P-0001", "index_pip", "--nm", "0.3"),
        ("range", "P-0001", "index_pip", "--from", "50", "--to", "10"),
        ("range", "P-0001", "index_pip", "--from", "nan", "--to", "10"),
        ("show", "P-0001", "--wrist-deg", "nan"),
        ("show", "P-0001", "--wrist-deg", "200"),
        ("show", "P-0001", "--robot", "toaster"),
    ):
        refused(data, "limits", *options)


def test_an_assistant_may_lower_but_not_raise(data):
    password = "correct horse battery"
    for name, role in (("bert", "assistant"), ("anna", "therapist")):
        arguments = ["user", "add", name, "--role", role, "--data", str(data), "--json"]
        assert CliRunner().invoke(app, arguments, input=password + "\n").exit_code == 0
    raising = ("limits", "raise", "P-0001", "index_pip", "--reason", "x", "--nm")
    assert "may not prescribe" in refused(data, *raising, "0.2", "--by", "bert")["value"]
    run(data, *raising, "0.1", "--by", "bert")
    run(data, *raising, "0.2", "--by", "anna")
    assert "one of" in refused(data, *raising, "0.2", "--by", "eve")["bound"]
