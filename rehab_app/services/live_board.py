"""The newest live picture, its error history and its camera image; readers take no lock."""

from __future__ import annotations

import threading
from collections import deque
from dataclasses import replace
from typing import Any

import numpy as np

from rehab_app.services.snapshot import LiveSnapshot
from sessions.records.fields import Float64

HISTORY_S = 30.0


class Board:
    """Written by the desk's threads, read by any number of pages."""

    def __init__(self) -> None:
        self._writing = threading.Lock()
        self._history: deque[tuple[float, float]] = deque()
        self.snapshot = LiveSnapshot()
        self.jpeg: bytes | None = None

    def update(self, **changes: Any) -> None:
        """Replace fields of the snapshot."""
        with self._writing:
            self.snapshot = replace(self.snapshot, **changes)

    def picture(self, **changes: Any) -> None:
        """Replace fields of the snapshot and count a new frame."""
        with self._writing:
            self.snapshot = replace(self.snapshot, frame=self.snapshot.frame + 1, **changes)

    def begin(self, **fields: Any) -> None:
        """Start an activity from a clean picture; the frame count goes on."""
        with self._writing:
            self._history.clear()
            self.jpeg = None
            self.snapshot = LiveSnapshot(frame=self.snapshot.frame, **fields)

    def add_error(self, t_s: float, rms_m: float) -> None:
        """Append one RMS fingertip error and forget what is older than 30 s."""
        with self._writing:
            self._history.append((t_s, rms_m))
            while self._history[0][0] < t_s - HISTORY_S:
                self._history.popleft()

    def error_history(self) -> tuple[Float64, Float64]:
        """t_s (n,) and error in millimetres (n,), as the chart draws it."""
        with self._writing:
            rows = np.array(self._history, dtype=np.float64).reshape(-1, 2)
        return rows[:, 0], 1e3 * rows[:, 1]
