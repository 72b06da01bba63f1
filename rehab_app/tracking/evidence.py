"""Captures whose markers have names, as the batch fits of ``rehab_app.hand`` take them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rehab_app.tracking.hand_filter import WRONG_DEPTH_M, Pairs
from rehab_app.tracking.sight import Sight
from sessions.records.fields import Float64


@dataclass(frozen=True, slots=True)
class Evidence:
    """Named markers of N captures, along rays.

    Attributes:
        p_m: Points, NaN where a marker was not seen; without depth somewhere on the ray, shape (N, M, 3).
        variance_m2: Of the sensor along the axes, infinite where nothing is known, shape (N, M, 3).
        axes: Two axes across each ray and the ray, as rows, shape (N, M, 3, 3).
    """

    p_m: Float64
    variance_m2: Float64
    axes: Float64

    def precision(self, wobble_m2: float) -> Float64:
        """1/variance along the axes when a marker's place on its bone varies as well, (N, M, 3), m^-2."""
        return 1.0 / (self.variance_m2 + wobble_m2)


def evidence(
    sight: Sight, pairs: Pairs, markers: int, near_m: Float64 | None, usual_range_m: float
) -> Evidence:
    """Evidence of one capture; of several detections of a marker the last counts.

    Args:
        sight: What was seen.
        pairs: Which detections are which markers.
        markers: How many markers there are.
        near_m: Where the markers are thought to be, shape (M, 3): depths far from it are not used. None
            when nobody knows.
        usual_range_m: Range at which rays without depth get their point where ``near_m`` is None.
    """
    p_m = np.full((markers, 3), np.nan)
    variance = np.full((markers, 3), np.inf)
    axes = np.tile(np.eye(3), (markers, 1, 1))
    marker, row = pairs.marker, pairs.row
    if not len(marker):
        return Evidence(p_m[None], variance[None], axes[None])
    ray, origin = sight.detections.ray_camera[row], sight.detections.origin_camera_m[row]
    expected_m = np.full(len(marker), usual_range_m)
    if near_m is not None:
        expected_m = ((near_m[marker] - origin) * ray).sum(axis=1)
    trusted = np.isfinite(sight.range_m[row])
    if near_m is not None:
        trusted &= ~(np.abs(sight.range_m[row] - expected_m) > WRONG_DEPTH_M) | pairs.insisted
    range_m = np.where(trusted, sight.range_m[row], expected_m)
    p_m[marker] = origin + range_m[:, None] * ray
    across = sight.across_rad2[row] * range_m**2 + pairs.extra_m2
    along = np.where(trusted, sight.range_variance_m2[row], np.inf)
    variance[marker] = np.stack([across, across, along], axis=1)
    axes[marker] = sight.axes[row]
    return Evidence(p_m[None], variance[None], axes[None])


def stacked(parts: list[Evidence]) -> Evidence:
    """Several captures as one."""
    return Evidence(
        np.concatenate([part.p_m for part in parts]),
        np.concatenate([part.variance_m2 for part in parts]),
        np.concatenate([part.axes for part in parts]),
    )
