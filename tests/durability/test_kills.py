"""Recordings and acts killed at random moments; the long run is ``make durability``."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]


def campaign(module, folder, kills, seed):
    """Figures of a campaign in a process of its own, which has no threads when it forks."""
    ran = subprocess.run(
        [
            sys.executable,
            "-m",
            f"tests.bench.durability.{module}",
            "--kills",
            str(kills),
            "--seed",
            str(seed),
        ],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
        env={"TMPDIR": str(folder), "PATH": "", "OPENBLAS_NUM_THREADS": "1"},
    )
    assert ran.returncode == 0, ran.stderr
    return json.loads(ran.stdout)


def test_twenty_kills_harm_nothing_sealed_and_lose_at_most_a_second(tmp_path):
    figures = campaign("kills", tmp_path, 20, 3)
    assert figures["kills"] == 20
    assert figures["sealed"] > 0
    assert figures["recovered"] + figures["finished"] > 0
    assert figures["worst_loss_s"] <= 1.0


def test_a_killed_migration_backup_restoring_and_erasure_goes_on_at_the_next_try(tmp_path):
    figures = campaign("acts", tmp_path, 2, 5)
    assert {"migration", "backup", "restoring", "erasure"} <= figures.keys()
    assert sum(figures[name] for name in ("migration", "backup", "restoring", "erasure")) > 0
