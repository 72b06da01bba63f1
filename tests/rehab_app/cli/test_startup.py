"""What a command does not use, it does not load."""

from __future__ import annotations

import subprocess
import sys

SCRIPT = """
import sys
from typer.testing import CliRunner
from rehab_app.cli.app import app

def run(*words):
    done = CliRunner().invoke(app, [*words, "--data", sys.argv[1]], input="a long enough password\\n")
    assert done.exit_code in (0, 2), done.output
    print(words[0], *sorted({"numba", "scipy", "mujoco", "cv2", "jinja2", "sqlalchemy"} & set(sys.modules)))

run("--help")
run("user", "list")
run("patient", "add", "--given", "A", "--family", "B", "--birth-date", "1950-01-31", "--side", "left")
run("patient", "list")
"""


def test_people_cost_no_simulation_no_camera_and_no_report(tmp_path):
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT, str(tmp_path)], capture_output=True, text=True, check=True
    )
    help_, users, added, patients = (line.split()[1:] for line in done.stdout.splitlines())
    assert help_ == []
    assert users == added == patients == ["sqlalchemy"]
