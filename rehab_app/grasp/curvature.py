"""Curvature of a finger at its joints, as chapter 3 of the thesis measures it."""

from __future__ import annotations

import numpy as np

from sessions.records.fields import Float64


def joint_curvature_per_m(points_m: Float64) -> Float64:
    """Curvature of the natural cubic spline through a digit's joints, with centripetal knots.

    Knots are spaced by the square root of the chord. A natural spline ends without curvature: the radii of
    1e13 to 1e17 that the thesis prints for MCP and TIP are round-off, and are exactly 0 here.

    Args:
        points_m: First joint, second joint, third joint and tip, shape (..., 4, 3 or 2), m.

    Returns:
        Curvature at the four points, shape (..., 4), 1/m.
    """
    chord = np.diff(points_m, axis=-2)
    step = np.sqrt(np.linalg.norm(chord, axis=-1))[..., None]
    rate = chord / step
    h0, h1, h2 = step[..., 0, :], step[..., 1, :], step[..., 2, :]
    right = 6.0 * np.diff(rate, axis=-2)
    # two unknown second derivatives, the outer two being nought
    a, b, c = 2 * (h0 + h1), h1, 2 * (h1 + h2)
    determinant = a * c - b * b
    second = np.stack(
        [
            (c * right[..., 0, :] - b * right[..., 1, :]) / determinant,
            (a * right[..., 1, :] - b * right[..., 0, :]) / determinant,
        ],
        axis=-2,
    )
    first = np.stack(
        [
            rate[..., 1, :] - h1 * (2 * second[..., 0, :] + second[..., 1, :]) / 6.0,
            rate[..., 2, :] - h2 * second[..., 1, :] / 3.0,
        ],
        axis=-2,
    )
    curvature = np.zeros(points_m.shape[:-1])
    curvature[..., 1:3] = _curvature(first, second)
    return curvature


def joint_radius_m(points_m: Float64) -> Float64:
    """Radius of curvature at the two inner joints, shape (..., 2), m; infinite in a straight digit."""
    curvature = joint_curvature_per_m(points_m)[..., 1:3]
    with np.errstate(divide="ignore"):
        radius: Float64 = 1.0 / curvature
    return radius


def _curvature(first: Float64, second: Float64) -> Float64:
    """|p' x p''| / |p'|^3 in any number of dimensions."""
    speed = (first**2).sum(axis=-1)
    along = (first * second).sum(axis=-1)
    cross = np.maximum(speed * (second**2).sum(axis=-1) - along**2, 0.0)
    # what is left of a straight digit is the rounding of a difference
    cross = np.where(cross < 1e-14 * speed * (second**2).sum(axis=-1), 0.0, cross)
    result: Float64 = np.sqrt(cross) / speed**1.5
    return result
