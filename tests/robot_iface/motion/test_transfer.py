from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robot_iface.errors import Refused
from robot_iface.motion import Transfer, transfer_speeds
from robot_iface.safety import shipped_limits
from robot_iface.types import Limits

PERIOD_S = 1e-3
NAMES = ("index_mcp_flexion", "index_pip", "thumb_ip")
angles = st.lists(st.floats(0.0, 1.5), min_size=3, max_size=3).map(np.array)


def limits(spastic: bool = False) -> Limits:
    return shipped_limits(NAMES, np.zeros(3), np.full(3, 1.5), spastic=spastic)


def track(transfer: Transfer, pauses: tuple[tuple[int, int], ...] = ()) -> tuple[np.ndarray, np.ndarray]:
    """Positions and speeds of every tick, (n, 3) each."""
    points = []
    while not transfer.done:
        tick = len(points)
        points.append(transfer.step(paused=any(a <= tick < b for a, b in pauses)))
        assert tick < 60_000, "never arrived"
    return np.array([p.q_rad for p in points]), np.array([p.dq_rad_s for p in points])


@given(
    start=angles, goal=angles, spastic=st.booleans(), pause=st.integers(0, 3000), length=st.integers(0, 900)
)
@settings(max_examples=60, deadline=None)
def test_transfers_are_straight_smooth_and_within_the_directed_speeds_also_when_paused(
    start: np.ndarray, goal: np.ndarray, spastic: bool, pause: int, length: int
) -> None:
    bounds = limits(spastic)
    transfer = Transfer(start, goal, bounds, PERIOD_S)
    q, speed = track(transfer, ((pause, pause + length),))
    assert np.array_equal(q[-1], goal)
    assert not speed[-1].any()
    way = np.vstack([start, q])
    velocity = np.diff(way, axis=0) / PERIOD_S
    assert (velocity <= bounds.flexion_speed_rad_s + 1e-6).all()
    assert (-velocity <= bounds.extension_speed_rad_s + 1e-6).all()
    assert np.abs(np.diff(np.vstack([np.zeros(3), speed]), axis=0)).max() <= 4.0 * PERIOD_S * 1.001
    assert len(q) * PERIOD_S <= transfer.seconds + length * PERIOD_S + 1.2
    if np.abs(goal - start).max() > 1e-3:
        share = (way - start) @ (goal - start) / ((goal - start) @ (goal - start))
        assert np.abs(way - start - share[:, None] * (goal - start)).max() < 1e-9, "not one straight line"
        assert np.diff(share).min() > -1e-9


def test_a_pause_brings_it_to_rest_until_it_is_resumed() -> None:
    transfer = Transfer(np.zeros(3), np.ones(3), limits(), PERIOD_S)
    _, speed = track(transfer, ((700, 1500),))
    assert speed[600].any()
    assert not speed[1100:1500].any()
    assert speed[1700].any()


def test_no_way_to_go_is_one_tick() -> None:
    here = np.array([0.1, 0.2, 0.3])
    q, speed = track(Transfer(here, here, limits(), PERIOD_S))
    assert np.array_equal(q, here[None])
    assert not speed.any()


def test_a_way_that_is_skipped_is_at_its_end() -> None:
    transfer = Transfer(np.zeros(3), np.ones(3), limits(), PERIOD_S)
    transfer.step()
    transfer.skip()
    assert transfer.done
    assert np.array_equal(transfer.step().q_rad, np.ones(3))
    assert transfer.fault == ""


def test_speeds_follow_the_direction_of_each_joint() -> None:
    speeds = transfer_speeds(np.array([0.2, 0.9, 0.5]), np.array([0.9, 0.2, 0.5]), limits(spastic=True))
    assert np.allclose(np.rad2deg(speeds), [60.0, 15.0, 60.0])


@pytest.mark.parametrize(
    ("goal", "speed", "thing"), [(np.nan, 1.0, "finite"), (1.0, 0.0, "speed"), (1.0, 1e-3, "600 s")]
)
def test_impossible_transfers_are_refused(goal: float, speed: float, thing: str) -> None:
    bounds = replace(limits(), flexion_speed_rad_s=np.full(3, speed))
    with pytest.raises(Refused, match=thing):
        Transfer(np.zeros(3), np.full(3, goal), bounds, PERIOD_S)
