from __future__ import annotations

import os
import subprocess
import sys
from itertools import pairwise
from typing import Any

import pytest

from robot_iface import loop
from robot_iface.loop import (
    PacedSimulatedClock,
    RealTimeClock,
    SimulatedClock,
    may_run_in_real_time,
    present_scheduling,
    request_realtime_priority,
)

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
    clock.wait_next_tick()
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


ASK = "from robot_iface.loop import *; print(may_run_in_real_time(), request_realtime_priority(), sep='\\n')"


def test_permission_is_told_before_it_is_used() -> None:
    said = subprocess.run([sys.executable, "-c", ASK], check=True, capture_output=True, text=True)
    permitted, phrase = said.stdout.splitlines()
    assert phrase.startswith("SCHED_FIFO" if permitted == "True" else "normal scheduling")
    assert present_scheduling()


def test_permission_comes_from_a_limit_or_a_capability(monkeypatch: Any) -> None:
    monkeypatch.setattr(loop.resource, "getrlimit", lambda _: (99, 99))
    assert may_run_in_real_time()
    monkeypatch.setattr(loop.resource, "getrlimit", lambda _: (0, 0))
    monkeypatch.setattr(loop.Path, "read_text", lambda _: "CapEff:\t0000000000000000\n")
    assert not may_run_in_real_time()
    monkeypatch.setattr(loop.Path, "read_text", lambda _: "CapEff:\t0000000000800000\n")
    assert may_run_in_real_time()


def test_opening_a_device_is_no_overrun(wall: Wall) -> None:
    clock = RealTimeClock(PERIOD_NS)
    wall.now += 2_000_000_000
    assert clock.wait_next_tick() == 0
    assert clock.overruns == 0


def test_paced_time_keeps_every_tick_and_tells_how_late_it_was(wall: Wall) -> None:
    ticks = []
    clock = PacedSimulatedClock(PERIOD_NS, lambda: ticks.append(1))
    start, wall.delay_ns = wall.now, 40_000
    for _ in range(98):
        assert clock.wait_next_tick() == 40_000
    wall.now += 5_000_000
    late = [clock.wait_next_tick() for _ in range(6)]
    assert late[0] == 4_040_000
    assert all(a > b for a, b in pairwise(late[:4])), "it does not catch up"
    assert clock.now_ns() == 104 * PERIOD_NS == len(ticks) * PERIOD_NS
    assert wall.now - start == 104 * PERIOD_NS + 40_000
    assert clock.late_ns(50.0) == pytest.approx(40_000, abs=1_000)
    assert clock.late_ns(100.0) == pytest.approx(4_040_000, abs=1_000)
    assert clock.overruns == 0


def test_after_a_long_stall_the_patient_is_not_rushed(wall: Wall) -> None:
    clock = PacedSimulatedClock(PERIOD_NS, lambda: None)
    clock.wait_next_tick()
    wall.now += 10_000_000_000
    hurried = 0
    while clock.wait_next_tick() > 0:
        hurried += 1
    assert hurried <= 251


def test_a_percentile_is_the_bin_that_reaches_it() -> None:
    clock = RealTimeClock(PERIOD_NS)
    assert clock.late_ns(99.0) == 0
    lateness = loop.Lateness()
    for late_us in (5, 7, 30_000):
        lateness.note(late_us * 1000)
    assert lateness.percentile_ns(33.0) == 6_000
    assert lateness.percentile_ns(66.0) == 8_000
    assert lateness.percentile_ns(100.0) == 20_001_000
