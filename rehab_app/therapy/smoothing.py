"""A smooth joint path through uncertain samples with gaps: least squares against third differences.

Minimises, joint by joint, sum w (q(t_i) - q_i)^2 / sigma_i^2 + sum (q''' / jerk)^2 at the samples' rate, with
Huber weights w, by a banded solve on a uniform grid. Both ends are at rest.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import solveh_banded

from sessions.records.fields import Float64, Int64

HUBER = 3.0
"""Distance of a sample, in standard deviations, from which its pull stops growing."""
BRIDGE_STD_RAD = 0.5
"""How surely a gap lies on the line between its ends: hardly; it only keeps a bridge from running away."""

SOFT_RAD = float(np.deg2rad(1.0))
"""Width of the bend at a bound."""
INSET = 0.1
"""Share of that width by which the bend ends before the bound: room for a spline between the knots."""

_ROUNDS = 12
_REST_SHARE = 30.0  # weight of rest at the ends over that of a third difference
_THIRD = np.array([-1.0, 3.0, -3.0, 1.0])


def smooth(t_s: Float64, q_rad: Float64, std_rad: Float64, grid_s: Float64, jerk_rad_s3: float) -> Float64:
    """Smooth one joint.

    Args:
        t_s: Sample times, rising, shape (N,).
        q_rad: Samples, NaN in gaps, shape (N,); one finite sample or more.
        std_rad: Standard deviation of each sample, shape (N,); ignored in gaps.
        grid_s: Uniform grid that covers the samples, shape (K,), K >= 8.
        jerk_rad_s3: Jerk that is taken for usual: smaller is smoother.

    Returns:
        The path on the grid, shape (K,).
    """
    seen = np.isfinite(q_rad)
    target = np.interp(t_s, t_s[seen], q_rad[seen])
    precision = np.where(seen, 1.0 / np.where(seen, std_rad, 1.0) ** 2, 1.0 / BRIDGE_STD_RAD**2)
    left: Int64 = np.clip(np.searchsorted(grid_s, t_s, side="right") - 1, 0, len(grid_s) - 2)
    share = (t_s - grid_s[left]) / (grid_s[left + 1] - grid_s[left])
    stiff = _stiffness(t_s, grid_s, jerk_rad_s3)
    weight = np.ones_like(t_s)
    path = np.zeros_like(grid_s)
    for _ in range(_ROUNDS):
        before = path
        path = _solve(stiff, left, share, precision * weight, target)
        off = np.abs((1.0 - share) * path[left] + share * path[left + 1] - target) * np.sqrt(precision)
        weight = np.where(seen, HUBER / np.maximum(off, HUBER), 1.0)
        if float(np.abs(path - before).max()) < 1e-5:
            break
    return path


def _stiffness(t_s: Float64, grid_s: Float64, jerk_rad_s3: float) -> Float64:
    """Third differences and rest at both ends as an upper banded matrix, shape (4, K)."""
    step_s = float(grid_s[1] - grid_s[0])
    sample_s = float(t_s[-1] - t_s[0]) / max(len(t_s) - 1, 1)
    factor = (step_s / sample_s) / (jerk_rad_s3 * step_s**3) ** 2
    size = len(grid_s)
    band = np.zeros((4, size))
    for i in range(4):
        for j in range(i, 4):
            band[3 - (j - i), j : size - 3 + j] += factor * _THIRD[i] * _THIRD[j]
    for k in (0, 1, size - 3, size - 2):
        band[3, k] += _REST_SHARE * factor
        band[3, k + 1] += _REST_SHARE * factor
        band[2, k + 1] -= _REST_SHARE * factor
    return band


def _solve(stiff: Float64, left: Int64, share: Float64, weight: Float64, target: Float64) -> Float64:
    """Banded normal equations of samples that lie between grid points."""
    size = stiff.shape[1]
    band = stiff.copy()
    band[3] += np.bincount(left, weight * (1.0 - share) ** 2, size)
    band[3] += np.bincount(left + 1, weight * share**2, size)
    band[2] += np.bincount(left + 1, weight * share * (1.0 - share), size)
    right = np.bincount(left, weight * (1.0 - share) * target, size)
    right += np.bincount(left + 1, weight * share * target, size)
    path: Float64 = solveh_banded(band, right)
    return path


def within(path_rad: Float64, low_rad: float, high_rad: float) -> Float64:
    """A path kept strictly inside a range by a smooth bend, where a plain clip would have corners.

    Within a degree of a bound the path is pressed together (by 0.7 degrees on the bound itself); 5 degrees
    inside, it is moved by less than 0.01 degrees.

    Args:
        path_rad: Any path, shape (K,).
        low_rad: Lower bound.
        high_rad: Upper bound, above the lower.
    """
    soft = min(SOFT_RAD, (high_rad - low_rad) / 12.0)
    low_rad, high_rad = low_rad + INSET * soft, high_rad - INSET * soft
    above = low_rad + soft * np.logaddexp(0.0, (path_rad - low_rad) / soft)
    inside: Float64 = high_rad - soft * np.logaddexp(0.0, (high_rad - above) / soft)
    return inside
