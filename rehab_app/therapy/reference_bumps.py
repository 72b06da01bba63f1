"""Smooth local changes of a path: cubic B-splines over equal windows of its time."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from scipy.interpolate import BSpline

from sessions.records.fields import Float64

WINDOW_S = 0.1
"""Length of a window, about."""

_ROUGH = 4.0  # weight of a bend beside that of a change
_CUBIC = 3


def windows(t_s: Float64) -> list[slice]:
    """Rows of each of W equal windows of equally spaced times, shape (K,), K at least 2."""
    count = max(2, round(float(t_s[-1] - t_s[0]) / WINDOW_S))
    edges = np.linspace(0, len(t_s), min(count, len(t_s)) + 1).round().astype(int).tolist()
    return [slice(first, last) for first, last in pairwise(edges)]


def bumps(t_s: Float64, count: int) -> Float64:
    """One smooth bump for each of W windows: shape (K, W).

    A cubic B-spline about the middle of its window, 0 from two windows away on. What would reach beyond an
    end is reflected there, so that every combination begins and ends at rest.

    Args:
        t_s: Equally spaced times, shape (K,).
        count: W, at least 2.
    """
    place = (t_s - t_s[0]) / (t_s[-1] - t_s[0]) * count - 0.5
    shapes = np.zeros((len(t_s), count))
    for window in range(-2, count + 2):
        spline = BSpline.basis_element(np.arange(window - 2.0, window + _CUBIC), extrapolate=False)
        inside = window if 0 <= window < count else -1 - window if window < 0 else 2 * count - 1 - window
        shapes[:, min(max(inside, 0), count - 1)] += np.nan_to_num(spline(place))
    return shapes


def roughness(count: int) -> Float64:
    """Matrix (W, W) of the sum of squared weights of W bumps and of their bends, both ends at 0."""
    ahead = np.zeros((count + 2, count))
    for row in range(count):
        ahead[row : row + 3, row] = 1.0, -2.0, 1.0
    return np.eye(count) + _ROUGH * ahead.T @ ahead
