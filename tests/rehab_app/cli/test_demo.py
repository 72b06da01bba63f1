from __future__ import annotations

import json
import stat
import subprocess
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

from rehab_app.access import CONSOLE
from rehab_app.bootstrap import open_clinic
from rehab_app.cli.app import app
from rehab_app.cli.demo_clinic import NAME, fill, sign_in
from rehab_app.cli.output import Output
from sessions.store import verify


@pytest.fixture(scope="module")
def demo(tmp_path_factory):
    folder = tmp_path_factory.mktemp("demo")
    arguments = ["demo", "--headless", "--seconds", "20", "--out", str(folder), "--json"]
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == 0, result.output
    return folder, json.loads(result.stdout)


def test_the_whole_loop_in_one_command(demo):
    _, made = demo
    assert {"take", "session", "report_html", "report_json", "wall_s", "simulated_s"} <= set(made)
    for name in ("take", "session"):
        verify(Path(made[name]))
    assert [one["mode"] for one in made["sessions"]] == ["passive", "assistive"]
    assert all(one["completed"] and not one["stops"] for one in made["sessions"])
    with open(made["report_json"], encoding="utf-8") as file:
        assert any(item["name"] == "joint_rmse" for item in json.load(file)["metrics"])
    assert made["simulated_s"] > 10.0


def test_the_demo_clinic_is_not_filled_twice_and_keeps_its_sign_in(demo):
    folder, _ = demo
    with open_clinic(folder) as clinic:
        before = clinic.sessions.list()
        fill(clinic, 20.0, 1, Output(False))
        assert clinic.sessions.list() == before
        (patient,) = clinic.patients.list()
        assert {row.patient_id for row in before} == {patient.id}
        password = sign_in(clinic)
        assert sign_in(clinic) == password
        assert clinic.accounts.sign_in(NAME, password).role == "therapist"
        assert clinic.accounts.list(CONSOLE)[0].name == NAME
    assert stat.S_IMODE((folder / "demo-sign-in.txt").stat().st_mode) == 0o600


def test_help_imports_nothing_heavy():
    code = (
        "import sys, rehab_app.cli.app\n"
        "heavy = {'numpy', 'scipy', 'mujoco', 'cv2', 'sqlalchemy', 'viser', 'matplotlib'}\n"
        "sys.exit(', '.join(sorted(heavy & set(sys.modules))) or 0)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_doctor_looks_at_everything_and_finds_what_was_never_sealed(tmp_path):
    (tmp_path / "takes").mkdir()
    (tmp_path / "takes" / "lost.partial.mcap").write_bytes(b"")
    result = CliRunner().invoke(app, ["doctor", "--json", "--data", str(tmp_path)])
    content = json.loads(result.stdout)
    names = [check["name"] for check in content["checks"]]
    assert list(dict.fromkeys(names)) == [
        "python",
        "simulation",
        "scheduling",
        "timing",
        "clinic folder",
        "port",
        "settings",
        "recording",
        "real hand",
    ]
    by_name = dict(zip(names, content["checks"], strict=True))
    assert by_name["recording"]["remedy"].startswith("restore it with: rehab-app recover")
    assert by_name["real hand"]["ok"]
    assert content["ok"] is False
