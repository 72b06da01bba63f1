"""Depths that contradict the hand again and again, always alike: then the hand is wrong, not the sensor."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rehab_app.tracking.hand_filter import WRONG_DEPTH_M, Pairs, Placed
from rehab_app.tracking.sight import Sight
from sessions.records.fields import Float64, Int64

Bool = NDArray[np.bool_]

_ALIKE_M = 0.012
_ENOUGH = 3


class DepthMemory:
    """How often in a row each marker's depth has been off by about the same.

    Args:
        markers: How many markers there are.
    """

    def __init__(self, markers: int) -> None:
        self._off_m: Float64 = np.zeros(markers)
        self._times: Int64 = np.zeros(markers, dtype=np.int64)

    @property
    def insisted(self) -> Bool:
        """Markers whose depths are to be believed, shape (M,)."""
        return self._times >= _ENOUGH

    def feed(self, after: Placed, sight: Sight, pairs: Pairs) -> None:
        """Take what a capture left between the hand and the depths."""
        off = sight.range_m[pairs.row] - sight.local(after.p_m[pairs.marker], pairs.row)[:, 2]
        for marker, apart in zip(pairs.marker[np.isfinite(off)], off[np.isfinite(off)], strict=True):
            alike = abs(apart - self._off_m[marker]) < _ALIKE_M
            insists = self._times[marker] >= _ENOUGH
            far = abs(apart) > (0.5 * WRONG_DEPTH_M if insists else WRONG_DEPTH_M)
            self._times[marker] = (self._times[marker] + 1 if alike or insists else 1) if far else 0
            self._off_m[marker] = apart
