"""Accounts and the proof of the audit through the real command line."""

from __future__ import annotations

import json

import pytest
from sqlalchemy import text
from typer.testing import CliRunner

from rehab_app.access import CONSOLE
from rehab_app.bootstrap import open_clinic
from rehab_app.cli.app import app

PASSWORD = "correct horse battery"


def invoke(data, *arguments, stdin=""):
    return CliRunner().invoke(app, [*arguments, "--data", str(data), "--json"], input=stdin)


@pytest.fixture
def data(tmp_path):
    for name, role in (("ada", "administrator"), ("tom", "therapist")):
        assert invoke(tmp_path, "user", "add", name, "--role", role, stdin=PASSWORD + "\n").exit_code == 0
    return tmp_path


def test_role_password_and_close_act_and_sign_out(data):
    assert json.loads(invoke(data, "user", "role", "tom", "assistant").stdout)["role"] == "assistant"
    assert invoke(data, "user", "password", "tom", stdin="another long sentence\n").exit_code == 0
    with open_clinic(data) as clinic:
        assert clinic.accounts.sign_in("tom", "another long sentence").role == "assistant"
        clinic.accounts.sign_ins.begin("tom", "d" * 64)
    assert invoke(data, "user", "close", "tom").exit_code == 0
    with open_clinic(data) as clinic:
        assert [one.name for one in clinic.accounts.list(CONSOLE)] == ["ada"]
        assert clinic.accounts.sign_ins.look("tom", "d" * 64) is None


@pytest.mark.parametrize(
    "arguments",
    [
        ("user", "close", "ada"),
        ("user", "role", "ada", "therapist"),
        ("user", "role", "tom", "root"),
        ("user", "close", "nobody"),
        ("user", "password", "nobody"),
    ],
)
def test_what_may_not_be_is_refused_in_a_sentence(data, arguments):
    answer = invoke(data, *arguments, stdin=PASSWORD + "\n")
    assert answer.exit_code == 1
    assert json.loads(answer.stdout)["error"]["message"]


def test_the_audit_is_proved_and_a_changed_row_is_found(data):
    proof = json.loads(invoke(data, "verify", "--audit").stdout)
    assert (proof["ok"], proof["rows"], len(proof["head"])) == (True, 2, 64)
    with open_clinic(data) as clinic, clinic.catalogue._writing() as session:
        session.execute(text("UPDATE audit SET actor = 'eve' WHERE seq = 1"))
    broken = invoke(data, "verify", "--audit")
    assert broken.exit_code == 1
    assert "audit row 1" in json.loads(broken.stdout)["error"]["message"]


@pytest.mark.parametrize("arguments", [("verify",), ("verify", "12345678", "--audit")])
def test_verify_wants_a_session_or_the_audit(data, arguments):
    assert invoke(data, *arguments).exit_code == 2


def test_a_patients_account_is_tied_to_one_patient(data):
    added = ("patient", "add", "--given", "Ada", "--family", "L", "--birth-date", "1950-12-31")
    assert json.loads(invoke(data, *added, "--side", "left").stdout)["namesakes"] == []
    bed = invoke(data, "user", "add", "bed", "--role", "patient", "--patient", "P-0001", stdin=PASSWORD)
    assert json.loads(bed.stdout)["patient"] == "P-0001"
    listed = json.loads(invoke(data, "user", "list").stdout)["users"]
    assert [one["patient"] for one in listed if one["name"] == "bed"] == ["P-0001"]
    assert json.loads(invoke(data, "user", "role", "bed", "patient").stdout)["patient"] == ""
    for wrong in (("bed", "patient", "--patient", "P-0404"), ("tom", "therapist", "--patient", "P-0001")):
        assert invoke(data, "user", "role", *wrong).exit_code == 1


def test_a_namesake_is_added_with_a_warning(data):
    given = ("--given", "Ada", "--family", "Rossi", "--birth-date", "1950-12-31", "--side", "left")
    assert "Warning" not in invoke(data, "patient", "add", *given).stderr
    again = invoke(data, "patient", "add", *given)
    assert again.exit_code == 0
    assert json.loads(again.stdout)["namesakes"] == ["P-0001"]
    assert "Warning: same name or birth date as P-0001" in again.stderr
