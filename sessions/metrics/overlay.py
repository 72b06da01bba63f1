"""Thins a movement to what a picture can show."""

from __future__ import annotations

import math

from sessions.metrics.summary import Curves
from sessions.records.fields import Float64

MOST_ROWS = 600


def thin(t_s: Float64, joints_rad: Float64, fingertips_m: Float64) -> Curves:
    """Every n-th row, so that at most 600 remain; gaps stay NaN.

    Args:
        t_s: Times, shape (N,).
        joints_rad: Angles, shape (N, 21).
        fingertips_m: Fingertips in the palm frame, shape (N, 5, 3).
    """
    step = max(1, math.ceil(len(t_s) / MOST_ROWS))
    return Curves(t_s[::step], joints_rad[::step], fingertips_m[::step])
