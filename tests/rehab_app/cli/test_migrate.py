"""``migrate --to``: from the file in the folder to a server, and on there."""

from __future__ import annotations

import json

from typer.testing import CliRunner

from rehab_app.access import CONSOLE
from rehab_app.bootstrap import open_clinic
from rehab_app.cli.app import app
from rehab_app.config import Settings
from tests.postgres_server import server


def run(*words):
    return CliRunner().invoke(app, [str(word) for word in words])


def test_a_clinic_moves_and_works_on_the_server(tmp_path):
    folder, url = tmp_path / "clinic", server().fresh()
    with open_clinic(folder) as clinic:
        clinic.patients.add(
            CONSOLE, given_name="Ada", family_name="Nowhere", birth_date="1950-01-01", side="left"
        )
    moved = run("migrate", "--to", url, "--data", folder, "--json")
    assert moved.exit_code == 0, moved.output
    tables = {table["name"]: table["rows"] for table in json.loads(moved.stdout)["tables"]}
    assert tables["patients"] == 1
    with open_clinic(folder, settings=Settings(catalogue_url=url)) as clinic:
        assert clinic.patients.get("P-0001").given_name == "Ada"
        rows = clinic.catalogue.verify_audit()
        assert rows == tables["audit"]
        copy = tmp_path / "copy"
        copy.mkdir()
        clinic.catalogue.copy_to(copy / "clinic.sqlite3")
    with open_clinic(copy, settings=Settings()) as clinic:
        assert clinic.patients.get("P-0001").given_name == "Ada"
        assert clinic.catalogue.verify_audit() == rows


def test_a_second_move_a_wrong_address_and_a_running_server_are_refused(tmp_path):
    folder, url = tmp_path / "clinic", server().fresh()
    assert run("migrate", "--to", url, "--data", folder).exit_code == 0
    for to, words in (
        (url, "empty"),
        ("nonsense", "catalogue_url"),
        ("postgresql://x:y@127.0.0.1:1/z", "not answering"),
    ):
        refused = run("migrate", "--to", to, "--data", folder)
        assert refused.exit_code == 1
        assert words in " ".join(refused.output.split())
    with open_clinic(folder, serving=True):
        refused = run("migrate", "--to", server().fresh(), "--data", folder)
    assert refused.exit_code == 1
    assert "served by process" in " ".join(refused.output.split())
