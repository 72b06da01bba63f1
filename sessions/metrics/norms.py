"""Range against a norm or the other hand, the grade of total active motion, lag against contracture."""

from __future__ import annotations

import math
from dataclasses import dataclass

from sessions.metrics.metric import Estimate, Interval
from sessions.metrics.motion_range import NORM_TOTAL_RAD

NORM_WORDS = "norm MCP 90, PIP 100, DIP 80, thumb MP 55, IP 80 deg"
"""The stated choice; others take 90 for DIP."""
NORM_RAD = {
    "mcp_flexion": math.radians(90.0),
    "pip": math.radians(100.0),
    "dip": math.radians(80.0),
}
NORM_THUMB_RAD = {"mcp_flexion": math.radians(55.0), "ip": math.radians(80.0)}
ASSH = "ASSH: 100 % excellent, over 75 good, over 50 fair, else poor"
"""Published tables disagree, so the scheme is named beside every grade."""


@dataclass(frozen=True, slots=True)
class Lag:
    """Why a joint does not straighten.

    Attributes:
        extension_lag: What the patient lacks beyond what the joint lacks: strength or gliding, rad.
        contracture: What is missing even when somebody straightens it, rad.
    """

    extension_lag: Estimate
    contracture: Estimate


def norm_of(joint: str) -> float | None:
    """Normal range of a joint, rad; None where this choice of norms has none."""
    digit, _, part = joint.partition("_")
    return (NORM_THUMB_RAD if digit == "thumb" else NORM_RAD).get(part)


def share_of(value: Estimate, whole: Estimate) -> Estimate:
    """One number over another, such as a range over its norm or over that of the other hand.

    Args:
        value: Upper number.
        whole: Lower number. Both intervals enter, as independent errors.
    """
    for part in (value, whole):
        if not math.isfinite(part.value):
            return Estimate.missing(part.reason)
    if not whole.value > 0.0:
        return Estimate.missing("the number that it is compared with is 0")
    share = value.value / whole.value
    if value.interval is None or whole.interval is None:
        return Estimate(share, None, value.reason)
    half = math.hypot(_half(value.interval) / whole.value, share * _half(whole.interval) / whole.value)
    return Estimate(share, (max(0.0, share - half), share + half), value.reason)


def active_motion_share(total_rad: Estimate) -> tuple[Estimate, str]:
    """Total active motion over the norm of 260 degrees, and its grade with the scheme named."""
    share = share_of(total_rad, Estimate(NORM_TOTAL_RAD, (NORM_TOTAL_RAD, NORM_TOTAL_RAD)))
    return share, f"{grade(share.value)} ({ASSH})" if math.isfinite(share.value) else ""


def grade(share: float) -> str:
    """Grade of total active motion after the scheme ``ASSH``; the share is rounded to 0.1 % first."""
    rounded = round(share, 3)
    if rounded >= 1.0:
        return "excellent"
    return "good" if rounded > 0.75 else "fair" if rounded > 0.5 else "poor"


def lag(active_deficit_rad: Estimate, passive_deficit_rad: Estimate) -> Lag:
    """Extension lag against contracture.

    Args:
        active_deficit_rad: Smallest angle that the patient reached by himself; hyperextension counts as none.
        passive_deficit_rad: Smallest angle to which the joint could be brought.
    """
    passive = _deficit(passive_deficit_rad)
    for part in (active_deficit_rad, passive_deficit_rad):
        if not math.isfinite(part.value):
            return Lag(Estimate.missing(part.reason or "active and passive range are both needed"), passive)
    active = _deficit(active_deficit_rad)
    value = max(0.0, active.value - passive.value)
    if active.interval is None or passive.interval is None:
        return Lag(Estimate(value), passive)
    half = math.hypot(_half(active.interval), _half(passive.interval))
    return Lag(Estimate(value, (max(0.0, value - half), value + half)), passive)


def _deficit(angle: Estimate) -> Estimate:
    interval = None if angle.interval is None else (max(0.0, angle.interval[0]), max(0.0, angle.interval[1]))
    return Estimate(max(0.0, angle.value) if math.isfinite(angle.value) else math.nan, interval, angle.reason)


def _half(interval: Interval) -> float:
    return 0.5 * (interval[1] - interval[0])
