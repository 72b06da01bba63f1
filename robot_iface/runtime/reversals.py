"""What follows from repetitions in which the load reversed the motion."""

from __future__ import annotations

from collections import deque
from enum import IntEnum

WINDOW = 5
NARROW_AT = 2
STOP_AT = 3


class Verdict(IntEnum):
    """What a repetition leads to."""

    GO_ON = 0
    NARROW = 1
    STOP = 2


class Reversals:
    """Two reversals in five repetitions take five degrees off the range; a third in five ends the run."""

    def __init__(self) -> None:
        self.count = 0
        """All reversals so far."""
        self._window: deque[bool] = deque(maxlen=WINDOW)

    def note(self, *, reversed_on_load: bool) -> Verdict:
        """Take one repetition."""
        self._window.append(reversed_on_load)
        if not reversed_on_load:
            return Verdict.GO_ON
        self.count += 1
        seen = sum(self._window)
        if seen >= STOP_AT:
            return Verdict.STOP
        return Verdict.NARROW if seen >= NARROW_AT else Verdict.GO_ON
