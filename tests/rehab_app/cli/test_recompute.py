"""recompute through the real command line."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest
from typer.testing import CliRunner

from rehab_app.bootstrap import open_clinic
from rehab_app.cli.app import app
from tests.rehab_app.services.recorded_sessions import add_sessions


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    made = tmp_path_factory.mktemp("clinic")
    with open_clinic(made) as clinic:
        add_sessions(clinic, 2, seconds=6.0)
    return made


def run(folder, *arguments):
    return CliRunner().invoke(app, ["recompute", *arguments, "--data", str(folder), "--json"])


def test_all_then_nothing_is_left_and_a_damaged_file_is_named(folder):
    first = run(folder, "--all", "--workers", "1")
    assert first.exit_code == 0, first.output
    told = json.loads(first.stdout)
    assert (told["files"], told["measured"], told["troubles"], told["norms"]) == (2, 2, [], 0)
    (folder / "sessions" / "broken.mcap").write_bytes(b"no session")
    with open_clinic(folder) as clinic:
        known = clinic.catalogue.sessions()[0]
        clinic.catalogue.add_session(replace(known, id="", sha256="b" * 64, path="sessions/broken.mcap"))
    again = run(folder, "--all", "--workers", "1")
    assert again.exit_code == 1
    found = json.loads(again.stdout)
    assert (found["kept"], found["measured"], len(found["troubles"])) == (2, 0, 1)
    assert found["digest"] == told["digest"]
    assert "Not measured: " in again.stderr


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ((), "neither --all nor --session"),
        (("--all", "--session", "abc"), "--all and --session"),
        (("--all", "--workers", "2", "--scheduler", "tcp://127.0.0.1:9"), "with --scheduler"),
        (("--session", "abc"), "abc unknown"),
        (("--all", "--metric", "beauty"), "beauty"),
    ],
)
def test_what_cannot_be_meant_is_one_sentence(folder, arguments, sentence):
    done = run(folder, *arguments)
    assert done.exit_code == 1
    assert sentence in json.loads(done.stdout)["error"]["message"]
