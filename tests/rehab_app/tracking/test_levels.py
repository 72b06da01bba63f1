"""Identity at every level, in short; the long form, with other trackers, is ``make bench-tracking``."""

from __future__ import annotations

from dataclasses import replace
from statistics import median

import pytest

from rehab_app.cameras import FACING
from rehab_app.cameras.sequence import point_sequence
from tests.bench.tracking.run import run_tracker
from tests.bench.tracking.score import Score, score

FRAMES = 240
SEEDS = (300, 301)


def scores(level: str) -> list[Score]:
    made = [point_sequence(level, seed, FRAMES) for seed in SEEDS]
    return [score(one, run_tracker("kinematic", one).tracks) for one in made]


@pytest.mark.parametrize(
    ("level", "idf1", "swaps", "rmse_px"),
    [("easy", 0.99, 0, 1.0), ("medium", 0.97, 1, 2.0), ("hard", 0.93, 3, 8.0), ("extreme", 0.70, 20, 30.0)],
)
def test_the_kinematic_tracker_keeps_names(level: str, idf1: float, swaps: int, rmse_px: float) -> None:
    results = scores(level)
    assert median(one.idf1 for one in results) >= idf1
    assert sum(one.swaps for one in results) <= swaps
    assert median(one.rmse_px for one in results) <= rmse_px


def test_two_cameras_keep_a_cylinder_grasp() -> None:
    one = point_sequence("hard", 302, 150, exercise="cylinder", views=FACING)
    either = replace(one, visible=one.view_visible.any(axis=0))
    assert either.visible.mean() > one.visible.mean() + 0.02
    assert score(either, run_tracker("kinematic", one).tracks).idf1 >= 0.95
