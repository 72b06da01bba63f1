"""Our trackers and others over the same sequences, a real hand, the whole pipeline: ``make bench-tracking``.

Prints the tables of ``docs/benchmarks.md`` and asserts what must be reached; of times it asserts nothing.
"""

from __future__ import annotations

import sys
from pathlib import Path
from statistics import median

import pytest

from rehab_app.cameras.levels import LEVELS
from tests.bench.tracking.mocap import mocap_sequence
from tests.bench.tracking.table import HEAD, METHODS, Method, at_level, measured
from tests.bench.tracking.whole_pipeline import run_pipeline

pytestmark = [pytest.mark.bench, pytest.mark.filterwarnings("ignore::DeprecationWarning")]

MUST_IDF1 = {"easy": 0.99, "medium": 0.97, "hard": 0.93, "extreme": 0.70}
MUST_SWAPS = {"medium": 2, "hard": 12}
MUST_RMSE_PX = {"medium": 1.0, "hard": 5.0}
QUICK = [method for method in METHODS if not method.name.startswith("Stone")]


def say(*lines: str) -> None:
    sys.stdout.write("\n".join(lines) + "\n")


def test_head() -> None:
    say("", HEAD)


@pytest.mark.parametrize("method", METHODS, ids=lambda method: method.name)
def test_levels(method: Method) -> None:
    rows = [at_level(method, level) for level in LEVELS]
    say(*(row.line() for row in rows))
    if method.name != "kinematic":
        return
    for row in rows:
        assert row.idf1 >= MUST_IDF1[row.level]
        assert row.swaps <= MUST_SWAPS.get(row.level, 1000)
        assert row.rmse_px <= MUST_RMSE_PX.get(row.level, 1000.0)


@pytest.mark.parametrize("method", QUICK, ids=lambda method: method.name)
@pytest.mark.parametrize("noisy", [False, True], ids=["clean", "noisy"])
@pytest.mark.parametrize("side", [1, -1], ids=["one side", "other side"])
def test_a_real_hand(method: Method, side: int, noisy: bool, shared_data: Path) -> None:
    seeds = (100, 101, 102, 103, 104) if noisy else (100,)
    label = f"real hand, {'noisy' if noisy else 'clean'}{'' if side > 0 else ', other side'}"
    row = measured(
        method,
        label,
        lambda seed: mocap_sequence(shared_data, seed, noisy=noisy, side_of_axis=side),
        seeds,
    )
    say(row.line())
    if method.name == "kinematic":
        assert row.idf1 >= (0.95 if noisy else 0.9995)


def test_whole_pipeline() -> None:
    runs = [run_pipeline("hard", seed, 20.0) for seed in (100, 101, 102)]
    for one in runs:
        say(
            f"hard, picture to hand: {one.fps:.0f} fps (median frame {one.median_fps:.0f}), detect "
            f"{one.detect_ms:.1f} ms, track {one.track_ms:.1f} ms; fingertips seen: median "
            f"{one.seen_median_mm:.1f} rms {one.seen_rms_mm:.1f} mm; hidden ones too: median "
            f"{one.all_median_mm:.1f} rms {one.all_rms_mm:.1f} mm; "
            f"labels astray {100 * one.wrong_share:.2f} %"
        )
    assert median(one.seen_median_mm for one in runs) <= 3.0
