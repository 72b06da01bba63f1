"""Pairs the monotonic clock with UTC once per session; everything else is integer nanoseconds."""

from __future__ import annotations

import time
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Timebase:
    """One instant, read on both clocks.

    Attributes:
        utc_start_ns: UTC since the epoch.
        monotonic_start_ns: Monotonic clock at the same instant.
    """

    utc_start_ns: int
    monotonic_start_ns: int

    @classmethod
    def now(cls) -> Timebase:
        """Read both clocks, keeping the pair whose readings lie closest together (three tries)."""
        pairs: list[tuple[int, Timebase]] = []
        for _ in range(3):
            before = time.monotonic_ns()
            utc = time.time_ns()
            after = time.monotonic_ns()
            pairs.append((after - before, cls(utc, (before + after) // 2)))
        return min(pairs, key=lambda pair: pair[0])[1]

    def to_utc_ns(self, monotonic_ns: int) -> int:
        """UTC of a monotonic time stamp, both in ns."""
        return self.utc_start_ns + monotonic_ns - self.monotonic_start_ns

    def to_monotonic_ns(self, utc_ns: int) -> int:
        """Monotonic time stamp of a UTC time, both in ns."""
        return self.monotonic_start_ns + utc_ns - self.utc_start_ns
