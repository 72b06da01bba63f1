"""Intervals end where the number itself ends: no time is below 0, no share above 100 %.

The t-interval of a mean over few strokes knows nothing of that. It is cut here, and the number says so.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

from sessions.metrics import Metric, Summary

CUT = "interval cut where the number itself ends"
_FROM_ZERO = (
    "fingertip_rmse joint_rmse timing_warp shape_error offset_error range_of_motion range_share "
    "movement_time peak_speed repetition_rate assistance stiffness interaction_torque dose_time aperture "
    "span finger_spread finger_to_palm longest_pause trigger_latency assistance_opening assistance_closing "
    "fit_residual longest_gap"
).split()
ENDS: Mapping[str, tuple[float, float]] = {name: (0.0, math.inf) for name in _FROM_ZERO} | {
    "path_ratio": (1.0, math.inf),
    "sparc": (-math.inf, 0.0),
    "sparc_floor": (-math.inf, 0.0),
    "valid_share": (0.0, 1.0),
    "robot_share": (0.0, 1.0),
    "amplitude_decrement": (-math.inf, 1.0),
    "kapandji": (0.0, 10.0),
}
"""Least and greatest value that a number can have, SI units; the others know no end."""


def possible(summary: Summary) -> Summary:
    """The same numbers; intervals that pass through impossible values are cut at the last possible one."""
    return replace(summary, metrics=tuple(within_ends(item) for item in summary.metrics))


def within_ends(item: Metric) -> Metric:
    """One number with its interval cut where it has to be, and flagged where it was."""
    if item.interval is None or item.name not in ENDS:
        return item
    least, most = (bound(item.value, end) for bound, end in zip((min, max), ENDS[item.name], strict=True))
    low, high = max(item.interval[0], least), min(item.interval[1], most)
    if (low, high) == item.interval:
        return item
    said = "" if item.status == "ok" else f"; {item.status.partition(': ')[2]}"
    return replace(item, interval=(low, high), status=f"flagged: {CUT}{said}")
