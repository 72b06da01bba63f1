"""Convex polygons in the plane of two joint angles: hull, inset, nearest point."""

from __future__ import annotations

import numpy as np

from robot_iface.types import Float64

_SAME_RAD = 1e-6
_STRAIGHT_RAD2 = 1e-9


def convex_hull(points_rad: Float64) -> Float64:
    """Corners of the smallest convex set that holds the points, counter-clockwise, without straight corners.

    Args:
        points_rad: Points, (N, 2).

    Returns:
        Corners, (K, 2); fewer than 3 where the points lie on a line.
    """
    _, apart = np.unique(np.round(points_rad / _SAME_RAD), axis=0, return_index=True)
    rows: list[list[float]] = sorted(points_rad[apart].tolist())
    if len(rows) < 3:
        return np.array(rows).reshape(-1, 2)
    lower, upper = _chain(rows), _chain(rows[::-1])
    corners = np.array(lower[:-1] + upper[:-1])
    return corners if len(corners) >= 3 else corners.reshape(-1, 2)


def area(corners_rad: Float64) -> float:
    """Area of a counter-clockwise polygon, (K, 2), rad^2; 0 with fewer than 3 corners."""
    if len(corners_rad) < 3:
        return 0.0
    x, y = corners_rad.T
    return 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))


def inset(corners_rad: Float64, margin_rad: float) -> Float64:
    """The convex polygon of all points that lie at least a margin inside every edge.

    Args:
        corners_rad: Counter-clockwise convex corners, (K, 2), K >= 3.
        margin_rad: Distance to every edge.

    Returns:
        Corners, (M, 2); fewer than 3 where nothing is left.
    """
    normals, offsets = half_planes(corners_rad)
    left = corners_rad
    for normal, offset in zip(normals, offsets, strict=True):
        left = _cut(left, normal, float(offset) - margin_rad)
        if len(left) < 3:
            return np.zeros((0, 2))
    return convex_hull(left)


def within_box(corners_rad: Float64, low_rad: Float64, high_rad: Float64) -> Float64:
    """The part of a convex polygon, (K, 2), that lies in a box with corners (2,); may be empty."""
    left = corners_rad
    for axis in range(2):
        for sign, bound in ((1.0, high_rad[axis]), (-1.0, -low_rad[axis])):
            normal = np.zeros(2)
            normal[axis] = sign
            left = _cut(left, normal, float(bound))
            if len(left) < 3:
                return np.zeros((0, 2))
    return convex_hull(left)


def half_planes(corners_rad: Float64) -> tuple[Float64, Float64]:
    """Outward unit normals (K, 2) and offsets (K,): inside is where normals @ p <= offsets."""
    edges = np.roll(corners_rad, -1, axis=0) - corners_rad
    normals = np.stack([edges[:, 1], -edges[:, 0]], axis=1)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    offsets: Float64 = np.einsum("kd,kd->k", normals, corners_rad)
    return normals, offsets


def outside(corners_rad: Float64, points_rad: Float64) -> Float64:
    """How far points, (N, 2), lie beyond the worst edge of a convex polygon, (N,); negative inside."""
    normals, offsets = half_planes(corners_rad)
    beyond: Float64 = (points_rad @ normals.T - offsets).max(axis=1)
    return beyond


def nearest(corners_rad: Float64, points_rad: Float64) -> Float64:
    """The points, (N, 2), each moved to the nearest one of a convex polygon where it is outside."""
    moved = points_rad.copy()
    away = outside(corners_rad, points_rad) > 0.0
    if not bool(away.any()):
        return moved
    points = points_rad[away]
    along = np.roll(corners_rad, -1, axis=0) - corners_rad
    share = ((points[:, None] - corners_rad) * along).sum(axis=2) / (along * along).sum(axis=1)
    feet = corners_rad + np.clip(share, 0.0, 1.0)[..., None] * along
    best = np.argmin(np.linalg.norm(feet - points[:, None], axis=2), axis=1)
    moved[away] = feet[np.arange(len(points)), best]
    return moved


def _chain(rows: list[list[float]]) -> list[list[float]]:
    """One half of the hull of points in order of their first coordinate (monotone chain)."""
    chain: list[list[float]] = []
    for row in rows:
        while len(chain) >= 2 and _turn(chain[-2], chain[-1], row) <= _STRAIGHT_RAD2:
            chain.pop()
        chain.append(row)
    return chain


def _turn(first: list[float], second: list[float], third: list[float]) -> float:
    """Twice the area of the triangle, positive for a turn to the left."""
    ahead = (second[0] - first[0]) * (third[1] - first[1])
    return ahead - (second[1] - first[1]) * (third[0] - first[0])


def _cut(corners: Float64, normal: Float64, offset: float) -> Float64:
    """What a half-plane leaves of a convex polygon, (K, 2)."""
    inside = offset - corners @ normal
    kept: list[Float64] = []
    for here in range(len(corners)):
        after = (here + 1) % len(corners)
        if inside[here] >= 0.0:
            kept.append(corners[here])
        if (inside[here] >= 0.0) != (inside[after] >= 0.0):
            share = inside[here] / (inside[here] - inside[after])
            kept.append(corners[here] + share * (corners[after] - corners[here]))
    return np.array(kept).reshape(-1, 2)
