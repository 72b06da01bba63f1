"""Backup, restore, export, erasure, retention and consent through the real command line."""

from __future__ import annotations

import json

import pytest
from typer.testing import CliRunner

from rehab_app.cli.app import app
from rehab_app.cli.privacy import ENVIRONMENT
from rehab_app.services import age

SENTENCE = "a long sentence for the safe"


def run(*arguments):
    result = CliRunner().invoke(app, [*(str(item) for item in arguments), "--json"])
    assert "Traceback" not in result.output
    return result.exit_code, json.loads(result.stdout)


def _open(locked, passphrase):
    key, _, text = locked.decode().partition("|")
    if key != passphrase:
        raise age.Unreadable("wrong")
    return text


@pytest.fixture(autouse=True)
def quick_passphrases(monkeypatch):
    """What makes guessing slow takes seconds each time; the services' tests keep one of them real."""
    monkeypatch.setattr(age, "lock", lambda text, passphrase: f"{passphrase}|{text}".encode())
    monkeypatch.setattr(age, "unlock", _open)


@pytest.fixture
def data(tmp_path):
    folder = tmp_path / "clinic"
    for family in ("Lovelace", "Hopper"):
        person = ("--given", "Ada", "--family", family, "--birth-date", "1950-12-31", "--side", "left")
        assert run("patient", "add", *person, "--data", folder)[0] == 0
    return folder


def test_a_clinic_comes_back_without_whom_it_erased(data, tmp_path, monkeypatch):
    monkeypatch.setenv(ENVIRONMENT, SENTENCE)
    code, made = run("backup", tmp_path / "one.rehab-backup", "--data", data)
    assert code == 0
    assert made["files"] >= 1
    assert run("patient", "erase", "P-0001", "--confirm", "P-0001", "--data", data)[1]["erased"]
    assert run("backup", tmp_path / "two.rehab-backup", "--data", data)[0] == 0  # asks for no passphrase
    secret = tmp_path / "passphrase.txt"
    secret.write_text(SENTENCE + "\n")
    monkeypatch.delenv(ENVIRONMENT)
    code, restored = run(
        "restore", tmp_path / "one.rehab-backup", "--passphrase-file", secret, "--data", tmp_path / "again"
    )
    assert code == 0
    assert restored["erased_again"] == ["P-0001"]
    rows = run("patient", "list", "--data", tmp_path / "again")[1]["patients"]
    assert [row["family_name"] for row in rows] == ["Hopper"]


def test_what_cannot_be_is_one_sentence(data, tmp_path, monkeypatch):
    monkeypatch.setenv(ENVIRONMENT, "short")
    assert "5 characters long" in run("backup", tmp_path / "x", "--data", data)[1]["error"]["message"]
    for words in (
        ("restore", tmp_path / "nothing", "--data", tmp_path / "new"),
        ("restore", __file__, "--data", tmp_path / "new"),
        ("restore", __file__, "--data", data),
        ("export", "P-0009", "--out", tmp_path / "x.zip", "--data", data),
        ("export", "P-0001", "--out", tmp_path / "x.txt", "--data", data),
        ("patient", "erase", "P-0001", "--confirm", "yes", "--data", data),
        ("retention", "set", 101, "--data", data),
        ("patient", "consent", "P-0009", "--data", data),
    ):
        code, said = run(*words)
        assert code == 1, words
        assert all(said["error"][key] for key in ("thing", "value", "bound", "remedy"))
    assert not (tmp_path / "new").exists()


def test_export_retention_and_consent(data, tmp_path):
    code, said = run("export", "P-0001", "--out", tmp_path / "one.zip", "--data", data)
    assert (code, said["files"]) == (0, ["README.txt", "identity.json", "record.json"])
    assert run("retention", "set", 7, "--data", data)[1] == {"years": 7}
    assert run("retention", "show", "--data", data)[1] == {"years": 7, "due": []}
    assert not run("patient", "consent", "P-0001", "--data", data)[1]["given"]
    assert run("patient", "consent", "P-0001", "--given", "--data", data)[1]["given"]
    said = run("patient", "consent", "P-0001", "--withdrawn", "--remove-images", "--data", data)[1]
    assert (said["given"], said["replaced_by"], len(said["history"])) == (False, [], 2)
