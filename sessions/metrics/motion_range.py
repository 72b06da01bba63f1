"""Range of motion of one joint, and total active motion of one finger.

The ends of the range are the largest and smallest angle that was *held for 0.1 s* after the low-pass filter.
A bare maximum grows with noise and with the length of the recording; a percentile shrinks with the time
spent at rest. The price: a 3 Hz tap of +-20 degrees reads 8 degrees short at either end.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from sessions.metrics.filtering import low_pass
from sessions.metrics.metric import Z95, Estimate
from sessions.metrics.spans import uniform_spans
from sessions.records.fields import Float64

HELD_S = 0.1
NORM_TOTAL_RAD = math.radians(260.0)
"""85 + 110 + 65 degrees, the norm that the grades of total active motion refer to."""


@dataclass(frozen=True, slots=True)
class JointRange:
    """Ends and width of a joint's range, each with its interval.

    Attributes:
        low: Smallest angle held, rad.
        high: Largest angle held, rad.
        width: high less low, rad.
    """

    low: Estimate
    high: Estimate
    width: Estimate


def joint_range(t_s: Float64, angle_rad: Float64, std_rad: Float64) -> JointRange:
    """Range of motion with 95 % intervals.

    The ends carry the median standard deviation s of the joint's angle, taken as independent between the
    two ends: low -+ 1.96 s, high -+ 1.96 s, width -+ 1.96 sqrt(2) s (the form of the minimal detectable
    change).

    Args:
        t_s: Times, shape (N,).
        angle_rad: Angles, shape (N,), NaN where not measured.
        std_rad: Standard deviation of each angle, shape (N,), NaN where unknown: then no interval.
    """
    lows: list[float] = []
    highs: list[float] = []
    for span in uniform_spans(t_s, angle_rad):
        smooth = low_pass(span.values, span.rate_hz)
        window = round(HELD_S * span.rate_hz) + 1
        highs.append(float(_inside(ndimage.minimum_filter1d(smooth, window), window).max()))
        lows.append(float(_inside(ndimage.maximum_filter1d(smooth, window), window).min()))
    if not highs:
        missing = Estimate.missing("never measured for 0.3 s without a gap")
        return JointRange(missing, missing, missing)
    low, high = min(lows), max(highs)
    known = std_rad[np.isfinite(angle_rad)]
    spread = float(np.median(known)) if bool(np.isfinite(known).all()) else math.nan
    width = max(0.0, high - low)
    return JointRange(
        Estimate(low, _around(low, spread)),
        Estimate(high, _around(high, spread)),
        Estimate(width, _around(width, math.sqrt(2.0) * spread, floor=0.0)),
    )


def total_active_motion(
    flexion_rad: Float64,
    extension_deficit_rad: Float64,
    flexion_std_rad: Float64 | None = None,
    deficit_std_rad: Float64 | None = None,
) -> Estimate:
    """Flexion of MCP, PIP and DIP at one instant of a fist, less the deficits of the straight finger.

    Args:
        flexion_rad: Angles of the three joints in the fullest fist, shape (3,).
        extension_deficit_rad: Angles of the three joints at the fullest opening, shape (3,); hyperextension
            (a negative angle) counts as no deficit.
        flexion_std_rad: Standard deviations of the former, shape (3,); None or NaN: no interval. Errors of
            the joints are taken as independent.
        deficit_std_rad: Standard deviations of the latter, shape (3,).
    """
    deficit = np.maximum(0.0, extension_deficit_rad)
    value = float(np.sum(flexion_rad) - np.sum(deficit))
    if not math.isfinite(value):
        return Estimate.missing("a joint of the finger was not measured in the fist or in the opening")
    if flexion_std_rad is None or deficit_std_rad is None:
        return Estimate(value)
    counted = np.where(extension_deficit_rad > 0.0, deficit_std_rad, 0.0)
    spread = math.sqrt(float(np.sum(flexion_std_rad**2) + np.sum(counted**2)))
    return Estimate(value, _around(value, spread))


def _inside(values: Float64, window: int) -> Float64:
    """The rows whose whole window lies within the span."""
    margin = window // 2
    return values[margin : values.size - margin] if values.size > 2 * margin else values


def _around(value: float, spread: float, floor: float = -math.inf) -> tuple[float, float] | None:
    if not math.isfinite(spread):
        return None
    return (max(floor, value - Z95 * spread), value + Z95 * spread)
