"""A brake on guessing: only so many failures per name and time window."""

from __future__ import annotations

import math
import threading
from collections import deque
from collections.abc import Callable

from rehab_app.errors import Refused

_REMEMBERED_NAMES = 10_000


class RateLimit:
    """Counts failures by key within a sliding window.

    Args:
        failures: Failures allowed within the window.
        window_s: Length of the window.
        now_s: Monotonic clock, s.
    """

    def __init__(self, failures: int, window_s: float, now_s: Callable[[], float]) -> None:
        self._failures = failures
        self._window_s = window_s
        self._now_s = now_s
        self._seen: dict[str, deque[float]] = {}
        self._lock = threading.Lock()

    def check(self, key: str) -> None:
        """Let an attempt pass.

        Raises:
            Refused: The key has failed too often; the sentence says how long to wait.
        """
        with self._lock:
            recent = self._recent(key)
            if len(recent) < self._failures:
                return
            wait_s = math.ceil(recent[0] + self._window_s - self._now_s())
        raise Refused(
            "sign-in",
            f"wrong {self._failures} times within {self._window_s:g} s",
            "tried less often",
            f"wait {max(wait_s, 1)} s and try again",
        )

    def fail(self, key: str) -> None:
        """Count one failure."""
        with self._lock:
            if len(self._seen) > _REMEMBERED_NAMES:
                self._seen.clear()  # bounded memory against made-up names; accounts stay argon2-slow
            self._recent(key).append(self._now_s())

    def succeed(self, key: str) -> None:
        """Forget the failures of a key."""
        with self._lock:
            self._seen.pop(key, None)

    def _recent(self, key: str) -> deque[float]:
        times = self._seen.setdefault(key, deque())
        while times and times[0] <= self._now_s() - self._window_s:
            times.popleft()
        return times
