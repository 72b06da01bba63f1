"""Angles kept inside a range without corners."""

from __future__ import annotations

import numpy as np

from sessions.records.fields import Float64

SOFT_RAD = float(np.deg2rad(1.0))
"""Width of the bend at a bound."""
INSET = 0.3
"""Share of that width by which the bend ends before the bound: room for a spline between the knots."""


def within(path_rad: Float64, low_rad: float, high_rad: float) -> Float64:
    """A path kept strictly inside a range by a smooth bend, where a plain clip would have corners.

    Within a degree of a bound the path is pressed together (by a degree on the bound itself); 5 degrees
    inside, it is moved by less than 0.02 degrees.

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
