"""The third coordinate of markers that are tracked in the image: measured, remembered, or unknown."""

from __future__ import annotations

import numpy as np

from rehab_app.geometry.detections import Detections
from rehab_app.geometry.pinhole import Intrinsics
from sessions.records.fields import Float64, Int64

_WALK_STD_M = 0.006  # by which a depth strays in a period of 30 Hz
_LARGEST_STD_M = 0.15
_GATE_M = 0.06  # farther off, a depth is that of the background or of another finger
_HAND_M = 0.15  # how far from the middle of the hand a marker of it may lie


def pinhole_of(detections: Detections, image_px: tuple[int, int]) -> Intrinsics | None:
    """The pinhole camera that gave detections their rays; None if they lie too close together to tell.

    Pixels are straight-line functions of the rays' slopes; focal lengths and principal point are that line.
    """
    if len(detections) < 2:
        return None
    slope = detections.ray_camera[:, :2] / detections.ray_camera[:, 2:]
    if not float(np.ptp(slope, axis=0).min()) > 1e-3:
        return None
    (fx, cx), (fy, cy) = (np.polyfit(slope[:, axis], detections.pixel_px[:, axis], 1) for axis in (0, 1))
    if not min(fx, fy) > 0:
        return None
    return Intrinsics(float(fx), float(fy), float(cx), float(cy), *image_px)


class DepthMemory:
    """The last credible depth of each marker and how unsure it has become.

    Args:
        markers: How many markers there are.

    Attributes:
        depth_m: Depth along the optical axis, NaN where none was ever seen, shape (M,).
        std_m: Its standard deviation, shape (M,).
    """

    def __init__(self, markers: int) -> None:
        self.depth_m: Float64 = np.full(markers, np.nan)
        self.std_m: Float64 = np.full(markers, _LARGEST_STD_M)

    def credible(self, markers: Int64, depth_m: Float64, periods: float) -> Int64:
        """Which of some markers' new depths are theirs, as rows into ``markers``; the memory grows older.

        Args:
            markers: Markers that were seen, shape (K,).
            depth_m: Their depths, NaN for none, shape (K,).
            periods: Time since the last capture in periods of 30 Hz.
        """
        grown = np.sqrt(self.std_m**2 + periods * _WALK_STD_M**2)
        self.std_m = np.minimum(grown, _LARGEST_STD_M)
        if not bool(np.isfinite(depth_m).any()):
            return np.empty(0, dtype=np.int64)
        known, middle = self.depth_m[markers], float(np.nanmedian(depth_m))
        off = np.where(np.isfinite(known), np.abs(depth_m - known), np.abs(depth_m - middle))
        gate = np.where(np.isfinite(known), _GATE_M + 4.0 * self.std_m[markers], _HAND_M)
        refused = off > gate
        # a memory that is contradicted again and again is the wrong one
        self.std_m[markers[refused]] = np.minimum(2.0 * self.std_m[markers[refused]], _LARGEST_STD_M)
        return np.flatnonzero(off <= gate)

    def remember(self, markers: Int64, depth_m: Float64, std_m: Float64) -> None:
        """Keep the depths (K,) of markers (K,)."""
        self.depth_m[markers] = depth_m
        self.std_m[markers] = np.minimum(std_m, _LARGEST_STD_M)

    def forget(self) -> None:
        """The hand is somewhere else now."""
        self.depth_m[:] = np.nan
        self.std_m[:] = _LARGEST_STD_M
