"""A way to a grasp over time: open, close, hold, open again."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import CubicSpline

from rehab_app.errors import Refused
from rehab_app.grasp.spiral import GraspPath
from sessions.records.fields import Float64

CLOSING_S, HOLD_S = 3.0, 1.0
"""Time from open to the grasp, and in it, unless others are asked for."""


def there_and_back(way: GraspPath, closing_s: float, hold_s: float, step_s: float) -> tuple[Float64, Float64]:
    """Times (K,) and angles (K, 21) there and back, each way with least jerk.

    Args:
        way: From the open hand to the posture.
        closing_s: Time from open to the grasp, 0.5 to 30 s; opening takes as long.
        hold_s: Time in the grasp, 0 to 60 s.
        step_s: Longest time between samples.

    Raises:
        Refused: A time is out of bounds.
    """
    for thing, value, low, high in (("closing", closing_s, 0.5, 30.0), ("hold", hold_s, 0.0, 60.0)):
        if not low <= value <= high:
            raise Refused(f"{thing} time", f"{value:g} s", f"{low:g} to {high:g} s", "choose another time")
    whole_s = 2.0 * closing_s + hold_s
    t_s = np.linspace(0.0, whole_s, int(np.ceil(whole_s / step_s)) + 1)
    u = np.clip(np.minimum(t_s, whole_s - t_s) / closing_s, 0.0, 1.0)
    along = u**3 * (10.0 - 15.0 * u + 6.0 * u**2)
    wish: Float64 = CubicSpline(way.s, way.joints_rad)(along)
    return t_s, wish
