"""A few rounds of a clinic's day leave nothing behind; eight hours of them are ``make soak``."""

from __future__ import annotations

import csv
import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
HOURS = 0.03
LEFT_FILES = 2
"""A connection of a browser may close a moment later."""
LEFT_THREADS = 2
"""The server's pool of threads breathes; one that every round left behind would make more."""


def test_rounds_of_a_day_leave_no_file_no_thread_and_little_memory(tmp_path):
    samples = tmp_path / "samples.csv"
    ran = subprocess.run(
        [
            *(sys.executable, "-m", "tests.bench.soak.clinic_day", "--samples", str(samples)),
            *("--hours", str(HOURS), "--minutes", "0.2"),
        ],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
        timeout=500,
        env=os.environ | {"TMPDIR": str(tmp_path), "OPENBLAS_NUM_THREADS": "1"},
    )
    assert ran.returncode == 0, ran.stderr
    with samples.open() as file:
        rounds = list(csv.DictReader(file))
    assert len(rounds) >= LEFT_THREADS + 3
    second, last = rounds[1], rounds[-1]
    assert int(last["files"]) <= int(second["files"]) + LEFT_FILES
    threads = [int(one["threads"]) for one in rounds]
    assert min(threads[-2:]) <= threads[1] + LEFT_THREADS
    assert float(last["memory_mb"]) <= 1.1 * float(second["memory_mb"])
