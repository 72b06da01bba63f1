"""Which detection belongs to which expected marker, by how much likelier that is than chance.

A pair's cost is minus twice the logarithm of a likelihood ratio: that the detection is this marker, against
that it is clutter. So a marker of which little is known does not take what fits a well-known neighbour, one
that faces away hardly takes anything, and a depth that is far off counts as the sensor's mistake, not as
another marker.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import linear_sum_assignment

from rehab_app.tracking.sight import Sight
from sessions.records.fields import Float64, Int64

NONE = -1
GATE = 16.0
"""Squared distance, in standard deviations, beyond which a pair is impossible."""
CLEAR = 6.0
"""By how much the best pair must beat the next, for both, to be taken without further thought."""
IMPOSSIBLE = 1e6
_FARTHEST_M = 0.15  # no marker is looked for farther than this across the ray from where it is expected
_DEPTH_WINDOW_M = 0.5  # wrong depths lie anywhere in a stretch as long as this
_WRONG_DEPTH = 0.04  # share of the depths that are wrong
_DEPTH_GATE = 9.0
_CLUTTER_M2 = 60.0  # false detections per square metre across the rays near a hand
_CLUTTER_M3 = 600.0  # and per cubic metre


@dataclass(frozen=True, slots=True)
class Expected:
    """The markers as a capture should show them.

    Attributes:
        p_camera_m: Places, shape (M, 3).
        covariance_m2: How surely, shape (M, 3, 3).
        seen_chance: Probability that each is detected at all, shape (M,).
    """

    p_camera_m: Float64
    covariance_m2: Float64
    seen_chance: Float64


def pair_costs(expected: Expected, sight: Sight) -> Float64:
    """Cost of every pair of marker and detection, shape (M, D); IMPOSSIBLE outside the gate."""
    markers, count = len(expected.p_camera_m), len(sight)
    cost = np.full((markers, count), IMPOSSIBLE)
    if not count:
        return cost
    marker, row = _candidates(expected, sight)
    local = sight.local(expected.p_camera_m[marker], row)
    axes = sight.axes[row]
    spread = axes @ expected.covariance_m2[marker] @ np.swapaxes(axes, 1, 2)
    across = sight.across_rad2[row] * local[:, 2] ** 2
    a, b, c = spread[:, 0, 0] + across, spread[:, 1, 1] + across, spread[:, 0, 1]
    area = a * b - c * c
    x, y = local[:, 0], local[:, 1]
    flat = (b * x * x - 2.0 * c * x * y + a * y * y) / area
    deep, deep_cost = _along(sight, spread, local, row, (a, b, c, area))
    two = flat + np.log(area) + 2.0 * np.log(2.0 * np.pi)
    without = two + 2.0 * np.log(_CLUTTER_M2)
    wrong = two + 2.0 * np.log(_CLUTTER_M3 * _DEPTH_WINDOW_M / _WRONG_DEPTH)
    right = np.where(deep < _DEPTH_GATE, two + deep_cost + 2.0 * np.log(_CLUTTER_M3), IMPOSSIBLE)
    known = np.isfinite(sight.range_m[row])
    price = np.where(known, np.minimum(right, wrong), without)
    price -= 2.0 * np.log(expected.seen_chance[marker])
    cost[marker, row] = np.where(flat < GATE, price, IMPOSSIBLE)
    return cost


def clear_pairs(cost: Float64, refusal: Float64, margin: float = CLEAR) -> Int64:
    """Pairs that are each other's best by a margin, shape (M,); NONE for every other marker.

    Args:
        cost: Cost of each pair, shape (M, D).
        refusal: Cost of leaving each marker without a detection, shape (M,).
        margin: By how much.
    """
    match = np.full(len(cost), NONE, dtype=np.int64)
    if not cost.size:
        return match
    best = cost.argmin(axis=1)
    rows = np.arange(len(cost))
    price = cost[rows, best]
    rivals = cost.copy()
    rivals[rows, best] = np.inf
    own = np.minimum(rivals.min(axis=1), refusal)
    # the cheapest other claim to the same detection
    others = rivals.min(axis=0)[best]
    claims = np.where(best[:, None] == best, price, np.inf)
    claims[rows, rows] = np.inf
    clear = np.minimum(np.minimum(own, others), claims.min(axis=1)) - price > margin
    match[clear] = best[clear]
    return match


def best_pairs(cost: Float64, refusal: Float64) -> Int64:
    """The cheapest one-to-one assignment in which markers may stay without a detection, shape (M,).

    Args:
        cost: Cost of each pair, shape (M, D).
        refusal: Cost of leaving each marker without a detection, shape (M,).
    """
    markers, count = cost.shape
    match = np.full(markers, NONE, dtype=np.int64)
    if not cost.size:
        return match
    alone = np.full((markers, markers), IMPOSSIBLE)
    np.fill_diagonal(alone, refusal)
    rows, columns = linear_sum_assignment(np.concatenate([cost, alone], axis=1))
    kept = (columns < count) & (cost[rows, np.minimum(columns, count - 1)] < IMPOSSIBLE)
    match[rows[kept]] = columns[kept]
    return match


def _candidates(expected: Expected, sight: Sight) -> tuple[Int64, Int64]:
    """Markers and rows of the pairs that lie near enough to be looked at closely."""
    apart = expected.p_camera_m[:, None] - sight.detections.origin_camera_m
    along = np.einsum("mdi,di->md", apart, sight.detections.ray_camera)
    aside = np.einsum("mdi,mdi->md", apart, apart) - along**2
    spread = np.trace(expected.covariance_m2, axis1=1, axis2=2)[:, None] + sight.across_rad2 * along**2
    pairs = np.argwhere((aside < np.minimum(GATE * spread, _FARTHEST_M**2)) & (along > 0.0))
    return pairs[:, 0], pairs[:, 1]


def _along(
    sight: Sight,
    spread: Float64,
    local: Float64,
    row: Int64,
    across: tuple[Float64, Float64, Float64, Float64],
) -> tuple[Float64, Float64]:
    """Squared distance along the ray, given the place across it, and its cost; NaN without depth."""
    a, b, c, area = across
    x, y = local[:, 0], local[:, 1]
    mixed_x, mixed_y = spread[:, 0, 2], spread[:, 1, 2]
    share_x = (b * mixed_x - c * mixed_y) / area
    share_y = (a * mixed_y - c * mixed_x) / area
    variance = spread[:, 2, 2] + sight.range_variance_m2[row] - share_x * mixed_x - share_y * mixed_y
    off = local[:, 2] - sight.range_m[row] - share_x * x - share_y * y
    square = off**2 / variance
    return square, square + np.log(2.0 * np.pi * variance)
