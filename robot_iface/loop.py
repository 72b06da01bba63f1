"""Clocks of the control loop: simulated time for repeatable runs, absolute deadlines for real devices."""

from __future__ import annotations

import math
import os
import resource
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from robot_iface.compiled import compiled
from robot_iface.types import Int64

_BIN_NS = 1_000
_BINS = 20_001
_MOST_BEHIND_NS = 250_000_000
_CAP_SYS_NICE = 23
PRIORITY = 50
"""Real-time priority of the loop: above every ordinary process, below the kernel's own threads."""


@compiled
def _bin_reached(counts: Int64, wanted: int) -> int:
    """First bin with which ``wanted`` samples are counted; quick, as lateness is small most of the time."""
    seen = 0
    for index in range(counts.size):
        seen += counts[index]
        if seen >= wanted:
            return index
    return counts.size - 1


class Lateness:
    """Histogram of how late ticks began, in microseconds up to 20 ms; costs nothing to look at in a tick."""

    def __init__(self) -> None:
        self._counts: Int64 = np.zeros(_BINS, dtype=np.int64)
        self._total = 0
        _bin_reached(self._counts, 1)  # compiled before the first tick

    def note(self, late_ns: int) -> None:
        """Count one tick."""
        self._counts[min(late_ns // _BIN_NS, _BINS - 1)] += 1
        self._total += 1

    def percentile_ns(self, percentile: float) -> int:
        """Lateness that a percentage of ticks did not exceed, rounded up to a microsecond; at most 20 ms."""
        if self._total == 0:
            return 0
        return (_bin_reached(self._counts, math.ceil(self._total * percentile / 100.0)) + 1) * _BIN_NS


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

    @property
    def scheduling(self) -> str:
        """That no scheduling matters."""
        return "simulated time"


class PacedSimulatedClock(SimulatedClock):
    """Simulated time that keeps pace with the wall clock, so that people can watch and act.

    Control and physics still advance one period at a time, so a stalled machine makes the simulation late,
    never different: no tick is skipped, none is an overrun. After a stall it makes up for 250 ms at most; the
    rest is left out of the wall clock's account instead of rushing the patient.

    Args:
        period_ns: Control period.
        advance: Called once a tick to advance the simulated device by one period.
    """

    def __init__(self, period_ns: int, advance: Callable[[], None]) -> None:
        super().__init__(period_ns, advance)
        self._start_ns = time.monotonic_ns()
        self._lateness = Lateness()

    def wait_next_tick(self) -> int:
        """Wait until the tick is due by the wall clock, then advance; returns how late it was."""
        due_ns = self._start_ns + self.now_ns() + self.period_ns
        ahead_ns = due_ns - time.monotonic_ns()
        if ahead_ns > 0:
            time.sleep(ahead_ns * 1e-9)
        elif ahead_ns < -_MOST_BEHIND_NS:
            self._start_ns += -ahead_ns - _MOST_BEHIND_NS
        late_ns = max(time.monotonic_ns() - due_ns, 0)
        self._lateness.note(late_ns)
        super().wait_next_tick()
        return late_ns

    def late_ns(self, percentile: float) -> int:
        """How late ticks were by the wall clock, at a percentile; at most 20 ms."""
        return self._lateness.percentile_ns(percentile)

    @property
    def scheduling(self) -> str:
        """What scheduling the loop has at this moment."""
        return present_scheduling()


class RealTimeClock:
    """Absolute deadlines on the monotonic clock; a missed tick is skipped and counted, never made up.

    The interpreter's sleep waits by ``clock_nanosleep`` to an absolute time (CPython 3.11 and later on
    Linux). The grid of deadlines begins with the first wait, so that opening a device is no overrun.

    Args:
        period_ns: Control period.
    """

    def __init__(self, period_ns: int) -> None:
        self.period_ns = period_ns
        self.overruns = 0
        """Waits that began after their deadline had passed."""
        self.overruns_in_row = 0
        """The same, consecutively, up to now."""
        self._deadline_ns = 0
        self._lateness = Lateness()

    def now_ns(self) -> int:
        """Monotonic time."""
        return time.monotonic_ns()

    def wait_next_tick(self) -> int:
        """Sleep to the next deadline that is still ahead and return how late the awakening is, in ns.

        A tick whose deadline has passed is an overrun; its lateness is that of the deadline that was missed.
        """
        self._deadline_ns = (self._deadline_ns or time.monotonic_ns()) + self.period_ns
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
        self._lateness.note(late_ns)
        return late_ns

    def late_ns(self, percentile: float) -> int:
        """Lateness that a percentage of ticks did not exceed, rounded up to a microsecond; at most 20 ms."""
        return self._lateness.percentile_ns(percentile)

    @property
    def scheduling(self) -> str:
        """What scheduling the loop has at this moment."""
        return present_scheduling()


def present_scheduling() -> str:
    """The scheduling of the calling thread, as the kernel has it, as a phrase."""
    if os.sched_getscheduler(0) != os.SCHED_FIFO:
        return "normal scheduling"
    return f"SCHED_FIFO, priority {os.sched_getparam(0).sched_priority}"


def may_run_in_real_time() -> bool:
    """Whether this process may ask for real-time priority: CAP_SYS_NICE, or a limit that allows it."""
    allowed, _ = resource.getrlimit(resource.RLIMIT_RTPRIO)
    if allowed == resource.RLIM_INFINITY or allowed >= PRIORITY:
        return True
    status = Path("/proc/self/status").read_text()
    held = next((line.split()[1] for line in status.splitlines() if line.startswith("CapEff:")), "0")
    return bool(int(held, 16) >> _CAP_SYS_NICE & 1)


def request_realtime_priority(priority: int = PRIORITY) -> str:
    """Ask for SCHED_FIFO for this process; without the permission the loop runs at normal priority.

    Returns:
        What was obtained, as a phrase for ``doctor`` and the log.
    """
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(priority))
    except OSError as error:
        return f"normal scheduling (real-time priority refused: {error.strerror})"
    return f"SCHED_FIFO, priority {priority}"
