"""Which detection belongs to which expected marker, in units of their joint uncertainty."""

from __future__ import annotations

import numpy as np
from scipy.optimize import linear_sum_assignment

from sessions.records.fields import Float64, Int64

NONE = -1
GATE = 16.0
"""Squared distance, in standard deviations, beyond which a pair is impossible (3 degrees of freedom)."""
CLEAR = 6.0
"""By how much the best pair must beat the next, for both, to be taken without further thought."""
_AWAY = 9.0  # added for a marker whose normal faces away: its blob should not be seen
_FAR = 1e6


def distances(
    expected_m: Float64, expected_covariance_m2: Float64, seen_m: Float64, seen_covariance_m2: Float64
) -> Float64:
    """Squared Mahalanobis distance plus the logarithm of the uncertainty's volume, per pair.

    The logarithm (relative to the smallest of all pairs) keeps a marker of which little is known from taking
    what fits a well-known neighbour.

    Args:
        expected_m: Expected markers, shape (M, 3).
        expected_covariance_m2: Their covariance, shape (M, 3, 3).
        seen_m: Detections, shape (D, 3).
        seen_covariance_m2: Their covariance, shape (D, 3, 3).

    Returns:
        Costs, shape (M, D); very large outside the gate.
    """
    apart = seen_m - expected_m[:, None]
    total = expected_covariance_m2[:, None] + seen_covariance_m2
    square = np.einsum("mdi,mdi->md", apart, np.linalg.solve(total, apart[..., None])[..., 0])
    volume = np.log(np.linalg.det(total))
    cost = square + volume - (volume.min() if volume.size else 0.0)
    return np.where(square < GATE, cost, _FAR)


def facing_penalty(normal_camera: Float64, p_camera_m: Float64) -> Float64:
    """Extra cost of each marker for facing away from the camera, shape (M,)."""
    cosine = -np.einsum("mi,mi->m", normal_camera, p_camera_m) / np.linalg.norm(p_camera_m, axis=1)
    return np.where(cosine < -0.05, _AWAY, 0.0)


def clear_pairs(cost: Float64) -> Int64:
    """Pairs that are each other's best by a margin, shape (M,); NONE for every other marker."""
    match = np.full(len(cost), NONE, dtype=np.int64)
    if not cost.size:
        return match
    best = cost.argmin(axis=1)
    for marker, detection in enumerate(best):
        price = cost[marker, detection]
        rivals = np.concatenate([np.delete(cost[marker], detection), np.delete(cost[:, detection], marker)])
        if price < _FAR and (not rivals.size or rivals.min() - price > CLEAR):
            match[marker] = detection
    return match


def best_pairs(cost: Float64) -> Int64:
    """The cheapest one-to-one assignment within the gate, shape (M,); NONE where there is none."""
    match = np.full(len(cost), NONE, dtype=np.int64)
    if cost.size:
        markers, detections = linear_sum_assignment(np.minimum(cost, 4.0 * GATE + _AWAY))
        kept = cost[markers, detections] < 4.0 * GATE
        match[markers[kept]] = detections[kept]
    return match
