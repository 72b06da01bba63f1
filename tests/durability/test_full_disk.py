"""A full disk at random places in recordings and acts; the long run is ``make durability``."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
ACTS = {"recording", "migration", "backup", "restoring", "erasure"}


def test_a_full_disk_harms_nothing_is_one_sentence_and_later_it_goes_on(tmp_path):
    ran = subprocess.run(
        [sys.executable, "-m", "tests.bench.durability.full_disk", "--times", "3", "--seed", "3"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
        env=os.environ | {"TMPDIR": str(tmp_path), "OPENBLAS_NUM_THREADS": "1"},
    )
    assert ran.returncode == 0, ran.stderr
    figures = json.loads(ran.stdout)
    assert figures.keys() >= ACTS
    assert figures["recording"] == 3
    assert sum(figures[name] for name in ACTS) > 6
