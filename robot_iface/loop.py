"""Clocks of the control loop: simulated time for repeatable runs, absolute deadlines for real devices."""

from __future__ import annotations

import os
import time
from collections.abc import Callable

import numpy as np

from robot_iface.types import Int64

_BIN_NS = 1_000
_BINS = 20_001


class SimulatedClock:
    """Time that passes only when it is waited for: the same inputs give the same run on any machine.

    Args:
        period_ns: Control period.
        advance: Called once a tick to advance the simulated device by one period.
    """

    def __init__(self, period_ns: int, advance: Callable[[], None]) -> None:
        self.period_ns = period_ns
        self._advance = advance
        self._now_ns = 0

    def now_ns(self) -> int:
        """Simulated time since the clock was made."""
        return self._now_ns

    def wait_next_tick(self) -> int:
        """Advance device and time by one period; never late."""
        self._advance()
        self._now_ns += self.period_ns
        return 0

    @property
    def overruns(self) -> int:
        """Ticks missed: none in simulated time."""
        return 0

    @property
    def overruns_in_row(self) -> int:
        """Consecutive ticks missed: none in simulated time."""
        return 0

    def late_ns(self, percentile: float) -> int:
        """Lateness at a percentile: 0 in simulated time, whichever is asked for."""
        del percentile
        return 0


class RealTimeClock:
    """Absolute deadlines on the monotonic clock; a missed tick is skipped and counted, never made up.

    The interpreter's sleep waits by ``clock_nanosleep`` to an absolute time (CPython 3.11 and later on
    Linux).

    Args:
        period_ns: Control period.
    """

    def __init__(self, period_ns: int) -> None:
        self.period_ns = period_ns
        self.overruns = 0
        """Waits that began after their deadline had passed."""
        self.overruns_in_row = 0
        """The same, consecutively, up to now."""
        self._deadline_ns = time.monotonic_ns()
        self._histogram: Int64 = np.zeros(_BINS, dtype=np.int64)

    def now_ns(self) -> int:
        """Monotonic time."""
        return time.monotonic_ns()

    def wait_next_tick(self) -> int:
        """Sleep to the next deadline that is still ahead and return how late the awakening is, in ns.

        A tick whose deadline has passed is an overrun; its lateness is that of the deadline that was missed.
        """
        self._deadline_ns += self.period_ns
        early_ns = self._deadline_ns - time.monotonic_ns()
        if early_ns >= 0:
            self.overruns_in_row = 0
            time.sleep(early_ns * 1e-9)
            late_ns = max(time.monotonic_ns() - self._deadline_ns, 0)
        else:
            late_ns = -early_ns
            self.overruns += 1
            self.overruns_in_row += 1
            self._deadline_ns += late_ns // self.period_ns * self.period_ns
        self._histogram[min(late_ns // _BIN_NS, _BINS - 1)] += 1
        return late_ns

    def late_ns(self, percentile: float) -> int:
        """Lateness that a percentage of ticks did not exceed, rounded up to a microsecond; at most 20 ms."""
        total = int(self._histogram.sum())
        if total == 0:
            return 0
        reached = np.cumsum(self._histogram) >= np.ceil(total * percentile / 100.0)
        return (int(np.argmax(reached)) + 1) * _BIN_NS


def request_realtime_priority(priority: int = 50) -> str:
    """Ask for SCHED_FIFO for this process; without the permission the loop runs at normal priority.

    Returns:
        What was obtained, as a phrase for ``doctor`` and the log.
    """
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(priority))
    except OSError as error:
        return f"normal scheduling (real-time priority refused: {error.strerror})"
    return f"SCHED_FIFO, priority {priority}"
