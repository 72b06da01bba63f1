from __future__ import annotations

import os
from itertools import pairwise
from typing import Any

import pytest

from robot_iface import loop
from robot_iface.loop import RealTimeClock, SimulatedClock, request_realtime_priority

PERIOD_NS = 1_000_000


def test_simulated_time_advances_the_device_once_a_tick() -> None:
    ticks = []
    clock = SimulatedClock(PERIOD_NS, lambda: ticks.append(1))
    for _ in range(1000):
        assert clock.wait_next_tick() == 0
    assert clock.now_ns() == 1000 * PERIOD_NS
    assert len(ticks) == 1000


class Wall:
    """A wall clock under the test's control: sleeping advances it, with a delay of its own."""

    def __init__(self) -> None:
        self.now = 5_000_000_000
        self.delay_ns = 0
        self.slept: list[float] = []

    def monotonic_ns(self) -> int:
        return self.now

    def sleep(self, seconds: float) -> None:
        self.slept.append(seconds)
        self.now += round(seconds * 1e9) + self.delay_ns


@pytest.fixture
def wall(monkeypatch: Any) -> Wall:
    wall = Wall()
    monkeypatch.setattr(loop, "time", wall)
    return wall


def test_deadlines_are_absolute_so_lateness_does_not_add_up(wall: Wall) -> None:
    clock = RealTimeClock(PERIOD_NS)
    start, wall.delay_ns = wall.now, 300_000
    lateness = [clock.wait_next_tick() for _ in range(100)]
    assert set(lateness) == {300_000}
    assert wall.now == start + 100 * PERIOD_NS + 300_000
    assert clock.overruns == 0


def test_missed_ticks_are_skipped_and_counted_never_made_up(wall: Wall) -> None:
    clock = RealTimeClock(PERIOD_NS)
    clock.wait_next_tick()
    wall.now += 5_400_000
    assert clock.wait_next_tick() == 4_400_000
    assert (clock.overruns, clock.overruns_in_row) == (1, 1)
    sleeps = len(wall.slept)
    times = []
    for _ in range(3):
        clock.wait_next_tick()
        times.append(wall.now)
    assert len(wall.slept) == sleeps + 3, "a burst"
    assert [b - a for a, b in pairwise(times)] == [PERIOD_NS] * 2
    assert (times[0] - 5_000_000_000) % PERIOD_NS == 0, "the grid was left"
    assert clock.overruns_in_row == 0


def test_consecutive_overruns_are_counted_in_a_row(wall: Wall) -> None:
    clock = RealTimeClock(PERIOD_NS)
    for count in range(1, 5):
        wall.now += 2_500_000
        clock.wait_next_tick()
        assert clock.overruns_in_row == count


def test_percentiles_come_from_the_histogram(wall: Wall) -> None:
    clock = RealTimeClock(PERIOD_NS)
    for tick in range(100):
        wall.delay_ns = 10_000 if tick < 98 else 700_000
        clock.wait_next_tick()
    assert clock.late_ns(50.0) == pytest.approx(10_000, abs=1_000)
    assert clock.late_ns(99.0) == pytest.approx(700_000, abs=1_000)


def test_without_permission_the_priority_stays_normal_and_says_so(monkeypatch: Any) -> None:
    def refuse(*_: Any) -> None:
        raise PermissionError(1, "Operation not permitted")

    monkeypatch.setattr(os, "sched_setscheduler", refuse)
    assert request_realtime_priority() == (
        "normal scheduling (real-time priority refused: Operation not permitted)"
    )
    monkeypatch.setattr(os, "sched_setscheduler", lambda *_: None)
    assert request_realtime_priority(60) == "SCHED_FIFO, priority 60"
