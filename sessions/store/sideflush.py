"""A thread that flushes what no later record would: after the last record before a silence."""

from __future__ import annotations

import threading
from collections.abc import Callable


class SideFlush:
    """Calls an action at an interval until it is stopped.

    Args:
        interval_s: Time between calls.
        action: What to call, from another thread; it must not raise.
    """

    def __init__(self, interval_s: float, action: Callable[[], None]) -> None:
        self._interval_s = interval_s
        self._action = action
        self._stopped = threading.Event()
        self._thread = threading.Thread(target=self._run, name="session-flush", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """End the calls and wait for the one that may be under way; safe to call twice."""
        self._stopped.set()
        self._thread.join()

    def _run(self) -> None:
        while not self._stopped.wait(self._interval_s):
            self._action()
