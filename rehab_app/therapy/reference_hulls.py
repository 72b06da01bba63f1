"""A path pulled into the sets that two joints of a finger may share."""

from __future__ import annotations

import numpy as np

from robot_iface.types import Hull
from sessions.records.fields import Float64

INSET_RAD = float(np.deg2rad(0.5))
"""How far inside a hull a path stays: room for a spline between the knots."""
NOTE_RAD = float(np.deg2rad(1.0))
"""From where on a pull is worth a sentence."""

_KERNEL = np.array([1.0, 4.0, 6.0, 4.0, 1.0]) / 16.0
_SMOOTHINGS = 3


def into_hulls(
    q_rad: Float64, names: tuple[str, ...], hulls: tuple[Hull, ...], take_s: Float64
) -> tuple[Float64, tuple[str, ...]]:
    """Pull a path into its hulls: the nearest allowed posture at every knot, then averaged over time.

    A mean of points of a convex set lies in it: averaging rounds the corners and breaks nothing.

    Args:
        q_rad: Angles, shape (K, J).
        names: The J joints.
        hulls: What pairs of them may share; a hull of other joints is passed over.
        take_s: Time in the take of each row, shape (K,).

    Returns:
        The path, shape (K, J), the very one given where no hull is left; and a sentence for each pull.
    """
    notes: list[str] = []
    path = q_rad
    for hull in hulls:
        if not set(hull.joints) <= set(names):
            continue
        columns = [names.index(name) for name in hull.joints]
        pair = path[:, columns]
        nearest = _nearest(pair, _inner(hull.corners_rad))
        off = np.linalg.norm(nearest - pair, axis=1)
        if float(off.max()) <= 0.0:
            continue
        path = path.copy()
        path[:, columns] = _averaged(nearest)
        worst = int(np.argmax(off))
        if off[worst] > NOTE_RAD:
            first, second = np.rad2deg(pair[worst])
            notes.append(
                f"{hull.joints[0]} at {first:.0f} deg with {hull.joints[1]} at {second:.0f} deg, at "
                f"{take_s[worst]:.1f} s of the take, is more than these two may bend together: pulled in by "
                f"{np.rad2deg(off[worst]):.0f} deg."
            )
    return path, tuple(notes)


def _inner(corners: Float64) -> tuple[Float64, Float64]:
    """Half planes normal . x <= bound of a hull drawn in by the inset, shapes (K, 2) and (K,)."""
    ahead = np.roll(corners, -1, axis=0) - corners
    outward = np.stack([ahead[:, 1], -ahead[:, 0]], axis=1) / np.linalg.norm(ahead, axis=1)[:, None]
    middle = corners.mean(axis=0)
    room = (outward * (corners - middle)).sum(axis=1)
    return outward, outward @ middle + room - np.minimum(INSET_RAD, 0.25 * room)


def _nearest(points: Float64, planes: tuple[Float64, Float64]) -> Float64:
    """The nearest points (K, 2) of a convex set: on an edge, or on a corner of two neighbouring edges."""
    outward, bound = planes
    best = points.copy()
    inside = (points @ outward.T <= bound + 1e-12).all(axis=1)
    least = np.where(inside, 0.0, np.inf)
    edges = [
        points - (points @ normal - at)[:, None] * normal for normal, at in zip(outward, bound, strict=True)
    ]
    for one in range(len(bound)):
        both = np.stack([outward[one], outward[(one + 1) % len(bound)]])
        corner = np.linalg.solve(both, bound[[one, (one + 1) % len(bound)]])
        edges.append(np.broadcast_to(corner, points.shape))
    for candidate in edges:
        allowed = (candidate @ outward.T <= bound + 1e-9).all(axis=1)
        off = np.where(allowed, np.linalg.norm(candidate - points, axis=1), np.inf)
        closer = off < least
        best[closer], least[closer] = candidate[closer], off[closer]
    return best


def _averaged(points: Float64) -> Float64:
    """Points (K, 2) averaged a few times over five rows; the ends keep their place."""
    for _ in range(_SMOOTHINGS):
        padded = np.pad(points, ((2, 2), (0, 0)), mode="edge")
        points = np.stack([np.convolve(column, _KERNEL, "valid") for column in padded.T], axis=1)
    return points
