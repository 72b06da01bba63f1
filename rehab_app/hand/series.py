"""Marker positions over time, gaps and all: what calibration and the importers pass around."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sessions.errors import Refused
from sessions.records.fields import Float64


@dataclass(frozen=True, slots=True)
class LandmarkSeries:
    """Positions of named markers over time.

    Attributes:
        t_s: Times, rising, shape (N,).
        names: Marker names, M of them.
        p_camera_m: Positions in the camera frame, NaN where a marker was not seen, shape (N, M, 3).

    Raises:
        Refused: The shapes disagree or time does not rise.
    """

    t_s: Float64
    names: tuple[str, ...]
    p_camera_m: Float64

    def __post_init__(self) -> None:
        shape = (self.t_s.size, len(self.names), 3)
        if self.p_camera_m.shape != shape:
            raise Refused(
                "marker series",
                f"of shape {self.p_camera_m.shape}",
                f"{shape}",
                "give one point per name and time",
            )
        if not bool(np.isfinite(self.t_s).all() and (np.diff(self.t_s) > 0).all()):
            raise Refused("marker time", "not rising everywhere", "rising", "sort the frames by time")

    @property
    def seen(self) -> NDArray[np.bool_]:
        """Whether each marker was seen, shape (N, M)."""
        return np.asarray(np.isfinite(self.p_camera_m).all(axis=2), dtype=np.bool_)

    @property
    def duration_s(self) -> float:
        """Time from the first to the last frame, s; 0 for fewer than two."""
        return float(self.t_s[-1] - self.t_s[0]) if self.t_s.size > 1 else 0.0

    def gap_spans(self) -> int:
        """Number of unbroken spans in which a marker is missing, over all markers."""
        missing = np.pad(~self.seen, ((1, 0), (0, 0)))
        return int((missing[1:] & ~missing[:-1]).sum())
