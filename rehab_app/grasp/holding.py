"""How far around an object a hand must reach to hold it, and how far it does."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from sessions.records.fields import Float64

FRICTION = 0.6
"""Assumed between skin or rubber and the object; a dry hand on plastic or paper has about that."""
HOLDING_ARC_RAD = math.pi - 2.0 * math.atan(FRICTION)
"""Two contacts hold an object when the line between them lies in both cones of friction, rad."""


_RADII_M = (0.004, 0.007, 0.010, 0.014, 0.019, 0.024, 0.030, 0.038, 0.047, 0.057, 0.068, 0.080, 0.095, 0.120)


def finger_arc_rad(points_m: Float64) -> float:
    """Angle around the object from the palm to the farthest contact of the fingers, over their side.

    Args:
        points_m: Joints and tips in the object's frame, shape (4, 4, 3).
    """
    return float(_angles(points_m)[:, 1:].max())


def thumb_arc_rad(points_m: Float64) -> float:
    """Angle around the object from the palm to the thumb's farthest contact, over the thumb's side.

    Args:
        points_m: Joints and tip in the object's frame, shape (4, 3).
    """
    return float(max(0.0, (-_angles(points_m[None]))[0].max()))


def held_range_m(holds: Callable[[float], bool]) -> tuple[float, float] | None:
    """The radii that can be held, to half a millimetre from inside; None where none of the tried ones is.

    Args:
        holds: Whether a radius in metres can be held.
    """
    held = [radius for radius in _RADII_M if holds(radius)]
    if not held:
        return None
    low, high = held[0], held[-1]
    below = low if low == _RADII_M[0] else _edge(holds, low, _RADII_M[_RADII_M.index(low) - 1])
    above = high if high == _RADII_M[-1] else _edge(holds, high, _RADII_M[_RADII_M.index(high) + 1])
    return below, above


def holdable(holds: Callable[[float], bool]) -> str:
    """The same in words.

    Args:
        holds: Whether a radius in metres can be held.
    """
    held = held_range_m(holds)
    if held is None:
        return f"no radius from {_RADII_M[0]:g} to {_RADII_M[-1]:g} m"
    return f"{held[0]:.4g} to {held[1]:.4g} m"


def _edge(holds: Callable[[float], bool], held_m: float, open_m: float) -> float:
    """The last radius that is held on the way to one that is not."""
    while abs(open_m - held_m) > 5e-4:
        middle = (held_m + open_m) / 2
        held_m, open_m = (middle, open_m) if holds(middle) else (held_m, middle)
    return held_m


def _angles(points_m: Float64) -> Float64:
    """Direction of each link's nearest point, continued along the digit, 0 towards the palm: (N, 3), rad."""
    start, way = points_m[:, :-1, :2], np.diff(points_m[..., :2], axis=1)
    part = np.clip(-(start * way).sum(axis=-1) / (way**2).sum(axis=-1), 0.0, 1.0)
    nearest = start + part[..., None] * way
    return np.unwrap(np.arctan2(nearest[..., 1], -nearest[..., 0]), axis=1)
