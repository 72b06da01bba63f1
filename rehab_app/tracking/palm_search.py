"""The back of the hand found by itself: its markers keep their pattern whatever the fingers do."""

from __future__ import annotations

import numpy as np
from scipy.optimize import linear_sum_assignment

from rehab_app.geometry.rotation import rigid_fit, turn
from rehab_app.tracking.labelling import NONE
from sessions.records.fields import Float64, Int64

FEWEST = 6
"""Markers on the palm without which its pattern is no pattern."""

_TURNS_RAD = np.deg2rad([-40.0, -20.0, 0.0, 20.0, 40.0])
_TILTS_RAD = np.deg2rad([[0.0, 0.0], [22.0, 0.0], [-22.0, 0.0], [0.0, 22.0], [0.0, -22.0]])
_COARSE_M = 0.015
_FINE_M = 0.007
_FIT_M = 0.004
_PROMISING = 6
_ROUNDS = 6


def palm_found(points_m: Float64, pattern_m: Float64, rotation: Float64) -> Int64 | None:
    """Lay the pattern of the palm's markers over detections.

    Every detection is tried as either of two markers, in turns and tilts around a rotation; the best of these
    are settled by assignment and rigid fit.

    Args:
        points_m: Detections, shape (D, 3).
        pattern_m: The palm's markers in the palm frame, shape (K, 3).
        rotation: Palm to camera, roughly, shape (3, 3).

    Returns:
        Detection of each marker, NONE where there is none, shape (K,); None if the palm is not there.
    """
    if len(pattern_m) < FEWEST or len(points_m) < FEWEST:
        return None
    spread = np.linalg.norm(pattern_m - pattern_m.mean(axis=0), axis=1)
    anchors = np.array([int(spread.argmin()), int(spread.argmax())])
    laid = pattern_m @ np.swapaxes(_rotations(rotation), 1, 2)
    shift = points_m[:, None] - laid[:, anchors].reshape(1, -1, 3)
    starts = np.repeat(laid, len(anchors), axis=0)[None] + shift[:, :, None]
    starts = starts.reshape(-1, len(pattern_m), 3)
    square = ((starts[:, :, None] - points_m) ** 2).sum(axis=3).min(axis=2)
    order = np.argsort(np.minimum(square, _COARSE_M**2).sum(axis=1), kind="stable")
    settled = [_settled(points_m, pattern_m, starts[index]) for index in order[:_PROMISING]]
    most = max(settled, key=lambda one: (int((one[0] != NONE).sum()), -one[1]))
    match, residual_m = most
    return match if int((match != NONE).sum()) >= FEWEST and residual_m < _FIT_M else None


def _rotations(rotation: Float64) -> Float64:
    """Turns in the image and tilts out of it around a rotation, shape (R, 3, 3)."""
    vectors = np.array([[x, y, z] for z in _TURNS_RAD for x, y in _TILTS_RAD])
    return turn(vectors) @ rotation


def _settled(points_m: Float64, pattern_m: Float64, placed_m: Float64) -> tuple[Int64, float]:
    """Alternate assignment and rigid fit; match (K,) and rms residual."""
    gate_m = _COARSE_M
    match, residual_m = np.full(len(pattern_m), NONE, dtype=np.int64), np.inf
    for _ in range(_ROUNDS):
        square = ((placed_m[:, None] - points_m) ** 2).sum(axis=2)
        rows, columns = linear_sum_assignment(np.minimum(square, gate_m**2))
        kept = square[rows, columns] < gate_m**2
        match = np.full(len(pattern_m), NONE, dtype=np.int64)
        match[rows[kept]] = columns[kept]
        if int(kept.sum()) < 4:
            return match, np.inf
        near, there = pattern_m[rows[kept]], points_m[columns[kept]]
        rotation, shift = rigid_fit(there[None], near, np.ones((1, len(near))))
        placed_m = pattern_m @ rotation[0].T + shift[0]
        residual_m = float(np.sqrt(((placed_m[rows[kept]] - there) ** 2).sum(axis=1).mean()))
        gate_m = max(0.8 * gate_m, _FINE_M)
    return match, residual_m
