"""Every clock of the control loop keeps the same promises."""

from __future__ import annotations

from typing import Any

import pytest

from robot_iface.loop import PacedSimulatedClock, RealTimeClock, SimulatedClock

PERIOD_NS = 2_000_000


CLOCKS = {
    "simulated": lambda: SimulatedClock(PERIOD_NS, lambda: None),
    "paced": lambda: PacedSimulatedClock(PERIOD_NS, lambda: None),
    "real": lambda: RealTimeClock(PERIOD_NS),
}


@pytest.fixture(params=sorted(CLOCKS))
def clock(request: Any) -> Any:
    return CLOCKS[request.param]()


def test_time_never_goes_back_and_each_tick_passes(clock: Any) -> None:
    times = [clock.now_ns()]
    for _ in range(5):
        late_ns = clock.wait_next_tick()
        times.append(clock.now_ns())
        assert isinstance(late_ns, int)
        assert late_ns >= 0
        assert times[-1] > times[-2]
    assert all(isinstance(time_ns, int) for time_ns in times)


def test_five_ticks_take_at_least_five_periods(clock: Any) -> None:
    first = clock.now_ns()
    for _ in range(5):
        clock.wait_next_tick()
    assert clock.now_ns() - first >= 4 * PERIOD_NS


def test_lateness_figures_are_ordered(clock: Any) -> None:
    assert clock.late_ns(50.0) == 0
    for _ in range(3):
        clock.wait_next_tick()
    assert 0 <= clock.late_ns(50.0) <= clock.late_ns(99.0)
    assert clock.overruns >= clock.overruns_in_row >= 0


def test_it_tells_its_scheduling(clock: Any) -> None:
    assert clock.scheduling
    assert isinstance(clock.scheduling, str)
