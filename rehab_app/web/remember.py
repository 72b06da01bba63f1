"""A short memory, so that four looks a second do not ask the catalogue four times a second."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Generic, TypeVar

T = TypeVar("T")
_MOST = 256


class Remembered(Generic[T]):
    """Remembers what ``find`` gave for a key; refusals are not remembered.

    Args:
        find: Looks a key up.
        seconds: How long an answer holds.
    """

    def __init__(self, find: Callable[[str], T], seconds: float) -> None:
        self._find = find
        self._seconds = seconds
        self._known: dict[str, tuple[float, T]] = {}

    def get(self, key: str) -> T:
        """The remembered or freshly found value; what ``find`` raises passes through."""
        now_s = time.monotonic()
        held = self._known.get(key)
        if held is not None and now_s - held[0] < self._seconds:
            return held[1]
        found = self._find(key)
        if len(self._known) >= _MOST:
            self._known.clear()
        self._known[key] = (now_s, found)
        return found

    def forget(self, key: str) -> None:
        """Ask again next time."""
        self._known.pop(key, None)
