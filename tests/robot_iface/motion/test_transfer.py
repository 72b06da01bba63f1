from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robot_iface.errors import Refused
from robot_iface.motion import plan_transfer, transfer_speeds
from robot_iface.safety import shipped_limits

PERIOD_S = 1e-3
angles = st.lists(st.floats(0.0, 1.5), min_size=3, max_size=3).map(np.array)


@given(start=angles, goal=angles, speed=st.floats(0.1, 1.0))
@settings(max_examples=60, deadline=None)
def test_transfers_are_straight_smooth_and_within_speed(
    start: np.ndarray, goal: np.ndarray, speed: float
) -> None:
    rows = plan_transfer(start, goal, np.full(3, speed), 5.0, PERIOD_S)
    assert np.array_equal(rows[-1], goal)
    track = np.vstack([start, rows])
    velocity = np.diff(track, axis=0) / PERIOD_S
    assert np.abs(velocity).max() <= speed + 1e-6
    assert np.abs(np.diff(np.vstack([np.zeros(3), velocity]), axis=0)).max() <= 5.0 * PERIOD_S * 1.05
    way = goal - start
    if np.abs(way).max() > 1e-3:
        share = (track - start) @ way / (way @ way)
        assert np.abs(track - start - share[:, None] * way).max() < 1e-6, "not one straight line"
        assert np.diff(share).min() > -1e-9


def test_no_way_to_go_is_one_row() -> None:
    here = np.array([0.1, 0.2])
    assert np.array_equal(plan_transfer(here, here, np.ones(2), 5.0, PERIOD_S), here[None])


def test_speeds_follow_the_direction_of_each_joint() -> None:
    limits = shipped_limits(("index_pip", "ring_pip"), np.zeros(2), np.ones(2), spastic=True)
    speeds = transfer_speeds(np.array([0.2, 0.9]), np.array([0.9, 0.2]), limits)
    assert np.allclose(np.rad2deg(speeds), [60.0, 15.0])


@pytest.mark.parametrize(
    ("goal", "speed", "thing"),
    [(np.nan, 1.0, "finite"), (1.0, 0.0, "speed"), (1.0, 1e-3, "ticks"), (1.0, 1e-6, "solvable")],
)
def test_impossible_transfers_are_refused(goal: float, speed: float, thing: str) -> None:
    with pytest.raises(Refused, match=thing):
        plan_transfer(np.zeros(2), np.full(2, goal), np.full(2, speed), 5.0, PERIOD_S)
