"""Whether the data base answers: where it did not just now, nobody waits for it again at once."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

from rehab_app.errors import NoAnswer

REST_S = 1.0


class Reach:
    """Remembers that the data base did not answer. Thread-safe.

    While it does not, one caller a second asks it and waits; all others are refused at once, so that a page
    does not wait once for each thing that it shows.

    Args:
        rest_s: How long it is not asked again.
        clock_s: Any clock that only goes on.
    """

    def __init__(self, rest_s: float = REST_S, clock_s: Callable[[], float] = time.monotonic) -> None:
        self._rest_s = rest_s
        self._clock_s = clock_s
        self._lock = threading.Lock()
        self._lost: NoAnswer | None = None
        self._again_s = 0.0

    @property
    def away(self) -> bool:
        """Whether it did not answer when it was asked last."""
        return self._lost is not None

    def check(self) -> None:
        """Refuse where it did not answer just now.

        Raises:
            NoAnswer: What was said then.
        """
        with self._lock:
            lost, now_s = self._lost, self._clock_s()
            if lost is None:
                return
            if now_s >= self._again_s:
                self._again_s = now_s + self._rest_s
                return
        raise NoAnswer(lost.thing, lost.value, lost.bound, lost.remedy)

    def lost(self, said: NoAnswer) -> None:
        """It did not answer."""
        with self._lock:
            self._lost, self._again_s = said, self._clock_s() + self._rest_s

    def answered(self) -> None:
        """It did."""
        if self._lost is not None:
            with self._lock:
                self._lost = None
