"""Twenty recordings killed at random moments; the long run is ``make durability``."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]


def test_twenty_kills_harm_nothing_sealed_and_lose_at_most_a_second(tmp_path):
    ran = subprocess.run(
        [sys.executable, "-m", "tests.bench.durability.kills", "--kills", "20", "--seed", "3"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
        env={"TMPDIR": str(tmp_path), "PATH": "", "OPENBLAS_NUM_THREADS": "1"},
    )
    assert ran.returncode == 0, ran.stderr
    figures = json.loads(ran.stdout)
    assert figures["kills"] == 20
    assert figures["sealed"] > 0
    assert figures["recovered"] + figures["finished"] > 0
    assert figures["worst_loss_s"] <= 1.0
