"""Places where blobs keep appearing in the image: what stands still, without misses, flicker, bad depth."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.optimize import linear_sum_assignment

from rehab_app.geometry.detections import Detections
from sessions.records.fields import Float64, Int64

NONE = -1
_USUAL_M = 0.7
_RADIUS_M = 0.007
_FEW = 0.4  # share of the usual number of blobs below which a capture counts as blank


def still_spots(captures: Sequence[Detections], share: float) -> Float64:
    """Where a blob was seen in most of some captures, shape (K, 3).

    Blobs are brought together in the image; a spot's range is the median over its blobs that have depth, and
    that of all spots where none has. So one bad depth in a few moves nothing.

    Args:
        captures: Detections of one camera, a moment apart.
        share: Of the captures that are not blank, in which a spot must be seen.
    """
    counts = np.array([len(one) for one in captures])
    filled = int((counts >= max(_FEW * float(np.median(counts)), 1.0)).sum())
    if filled == 0:
        return np.empty((0, 3))
    flat = np.concatenate([_flat(one) for one in captures])
    depth = np.concatenate([one.p_camera_m[:, 2] for one in captures])
    frame = np.repeat(np.arange(len(captures)), counts)
    middle_m = _median(depth, _USUAL_M)
    groups = _groups(flat, frame, _RADIUS_M / middle_m, share * filled)
    places = np.array([np.median(flat[group], axis=0) for group in groups]).reshape(-1, 2)
    depths = np.array([_median(depth[group], np.nan) for group in groups])
    depths = np.where(np.isfinite(depths), depths, _median(depths, middle_m))
    return np.concatenate([places, np.ones((len(places), 1))], axis=1) * depths[:, None]


def nearest_in_image(spots_m: Float64, detections: Detections, gate_m: float) -> Int64:
    """The detection of each spot, NONE where none is near, shape (K,); no detection serves two spots.

    Args:
        spots_m: Where blobs were, NaN for none, shape (K, 3).
        detections: What one camera sees.
        gate_m: Farthest, across the line of sight at the spot's range.
    """
    known = np.flatnonzero(np.isfinite(spots_m).all(axis=1))
    match = np.full(len(spots_m), NONE, dtype=np.int64)
    depth = spots_m[known, 2:]
    apart = np.linalg.norm((spots_m[known, :2] / depth)[:, None] - _flat(detections), axis=2) * depth
    rows, columns = linear_sum_assignment(np.minimum(apart, 2.0 * gate_m))
    near = apart[rows, columns] < gate_m
    match[known[rows[near]]] = columns[near]
    return match


def _flat(detections: Detections) -> Float64:
    """Where the rays meet a plane at unit depth, shape (D, 2)."""
    return detections.ray_camera[:, :2] / detections.ray_camera[:, 2:]


def _median(values: Float64, otherwise: float) -> float:
    """Median of those that are finite, or another value where none is."""
    known = values[np.isfinite(values)]
    return float(np.median(known)) if known.size else otherwise


def _groups(flat: Float64, frame: Int64, radius: float, fewest: float) -> list[Int64]:
    """Rows that belong together, one a frame at most; the most frequent first."""
    apart = np.linalg.norm(flat[:, None] - flat, axis=2)
    near = apart < radius
    by_frame = (frame[:, None] == np.arange(int(frame[-1]) + 1)).astype(np.float64)
    votes = ((near @ by_frame) > 0.0).sum(axis=1)
    free = np.ones(len(flat), dtype=np.bool_)
    groups: list[Int64] = []
    for row in np.argsort(-votes, kind="stable"):
        if votes[row] < fewest:
            break
        members = np.flatnonzero(near[row] & free)
        members = members[np.argsort(apart[row, members], kind="stable")]
        _, first = np.unique(frame[members], return_index=True)
        if free[row] and len(first) >= fewest:
            groups.append(members[first])
            free[members[first]] = False
    return groups
