"""What became of the markers of a recording: measured, estimated or lost, over all of it and lately."""

from __future__ import annotations

from collections import deque

import numpy as np
from numpy.typing import NDArray

from rehab_app.tracking import TrackedHand
from sessions.records import Status
from sessions.records.fields import Float64

_LATELY_NS = 1_000_000_000


class Quality:
    """Counts statuses, capture by capture."""

    def __init__(self) -> None:
        self.frames = 0
        self.gaps = 0
        self._counts = np.zeros(len(Status), dtype=np.int64)
        self._square_m2 = 0.0
        self._fitted = 0
        self._missed: NDArray[np.bool_] | None = None
        self._lately: deque[tuple[int, Float64]] = deque()

    def add(self, tracked: TrackedHand) -> None:
        """Count one capture; they come in the order of time."""
        status = tracked.markers.status
        counts = np.bincount(status, minlength=len(Status)).astype(np.float64)
        self.frames += 1
        self._counts += counts.astype(np.int64)
        missed = status != Status.MEASURED
        before = np.zeros_like(missed) if self._missed is None else self._missed
        self.gaps += int((missed & ~before).sum())
        self._missed = missed
        if np.isfinite(tracked.pose.residual_m):
            self._square_m2 += tracked.pose.residual_m**2
            self._fitted += 1
        self._lately.append((tracked.markers.t_ns, counts))
        while self._lately[0][0] <= tracked.markers.t_ns - _LATELY_NS:
            self._lately.popleft()

    def share(self, status: Status) -> float:
        """Share of all markers in all captures with a status, 0 to 1; 0 before the first capture."""
        return float(self._counts[status] / max(int(self._counts.sum()), 1))

    def lately(self) -> tuple[float, float, float]:
        """Shares lost, estimated and measured over the last second; all lost before the first capture."""
        if not self._lately:
            return 1.0, 0.0, 0.0
        total = np.sum([counts for _, counts in self._lately], axis=0)
        lost, estimated, measured = total / max(float(total.sum()), 1.0)
        return float(lost), float(estimated), float(measured)

    @property
    def residual_m(self) -> float:
        """Root mean square distance of fitted from seen markers; NaN while nothing was fitted."""
        return float(np.sqrt(self._square_m2 / self._fitted)) if self._fitted else float("nan")
