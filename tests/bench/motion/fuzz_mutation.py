"""``make mutate``: cosmic-ray over a copy of the tree, on a seeded sample of its mutants."""

from __future__ import annotations

import os
import random
import shutil
import sqlite3
import subprocess
import sys
import tempfile
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parents[3]
CONFIG = "tests/mutation.toml"
SEED = 4
_PENDING = "SELECT job_id FROM mutation_specs WHERE job_id NOT IN (SELECT job_id FROM work_results)"
_PLACE = " ORDER BY module_path, start_pos_row, start_pos_col, operator_name, occurrence, operator_args"
_SKIP = "INSERT INTO work_results (worker_outcome, output, job_id) VALUES ('SKIPPED', 'not in the sample', ?)"
_COUNT = (
    "SELECT test_outcome, COUNT(*) FROM work_results WHERE worker_outcome = 'NORMAL' GROUP BY test_outcome"
)


def main() -> int:
    """Copy, mutate, report; the number of mutants is the first argument, 0 for all."""
    wanted = int(sys.argv[1]) if len(sys.argv) > 1 else 200
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder)
        for name in ("robot_iface", "tests", "docs", "pyproject.toml"):
            source = REPOSITORY / name
            (shutil.copytree if source.is_dir() else shutil.copy2)(source, copy / name)
        (copy / ".venv").symlink_to(REPOSITORY / ".venv")
        _run(copy, "cosmic-ray", "init", CONFIG, "session.sqlite")
        _run(copy, "cr-filter-operators", "session.sqlite", CONFIG)
        pending = _sample(copy / "session.sqlite", wanted)
        sys.stdout.write(f"{pending}\n")
        _run(copy, "cosmic-ray", "exec", CONFIG, "session.sqlite")
        _run(copy, "cr-report", "--show-diff", "--surviving-only", "session.sqlite")
        with sqlite3.connect(copy / "session.sqlite") as session:
            sys.stdout.write(f"{dict(session.execute(_COUNT).fetchall())}\n")
    return 0


def _run(copy: Path, command: str, *arguments: str) -> None:
    """Run a command of cosmic-ray in the copy, whose sources come before the installed ones."""
    environment = {**os.environ, "PYTHONPATH": str(copy), "PYTHONDONTWRITEBYTECODE": "1"}
    subprocess.run(
        [REPOSITORY / ".venv" / "bin" / command, *arguments], cwd=copy, env=environment, check=True
    )


def _sample(session_file: Path, wanted: int) -> str:
    """Leave so many mutants to do, drawn by one seed; returns how many of how many."""
    with sqlite3.connect(session_file) as session:
        jobs = [row[0] for row in session.execute(_PENDING + _PLACE)]
        kept = set(random.Random(SEED).sample(jobs, min(wanted, len(jobs)))) if wanted else set(jobs)
        session.executemany(_SKIP, [(job,) for job in jobs if job not in kept])
    return f"{len(kept)} of {len(jobs)} mutants"


if __name__ == "__main__":
    raise SystemExit(main())
