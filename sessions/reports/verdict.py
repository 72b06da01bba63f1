"""Whether a change between two sessions is real, below what can be told apart, or not measurable at all."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, TypeAlias

from sessions.metrics import definition
from sessions.reports.language import _, marked
from sessions.reports.past import Kept, Past
from sessions.reports.remarks import remark
from sessions.reports.wording import exercise_words, mode_words

Verdict: TypeAlias = Literal["real", "below MDC", "not measurable"]
Bound: TypeAlias = Callable[[str, str, str], float | None]
"""Minimal detectable change of a metric and subject by a source, SI units; None where nobody measured it."""
VERDICTS = (marked("real"), marked("below MDC"), marked("not measurable"))
STRETCH_RAD = math.radians(2.0)
"""What stretching alone gains (Cochrane review): a gain no larger than that is nobody's success."""
SAME_STIFFNESS = 0.1
ERRORS = ("fingertip_rmse", "joint_rmse", "timing_delay", "timing_warp", "shape_error", "offset_error")
HELPED = frozenset(("passive", "assistive"))
"""Modes in which the robot moves the hand."""
_BARE_CAMERA = ("mediapipe", "leap", "markerless", "video")
_SMALLEST_SHARE = {"sparc": 0.35, "ldlj": 0.31, "path_ratio": 0.54, "peak_speed": 0.17}


@dataclass(frozen=True, slots=True)
class Change:
    """One number now against the same number before.

    Attributes:
        difference: Now less before, SI units; NaN where one is missing.
        verdict: What may be said of it.
        bound: Change that it is measured against, SI units; NaN where there is none.
        why: Where the bound comes from, or why nothing can be said.
    """

    difference: float
    verdict: Verdict
    bound: float
    why: str


def comparable(before: Past, after: Past, name: str, subject: str) -> str:
    """Why two sessions may not be compared in this number, empty where they may."""
    one, other = before.number(name, subject), after.number(name, subject)
    if one is None or other is None or one.value is None or other.value is None:
        return _("not measured in both")
    if before.side != after.side:
        return _("another hand")
    if one.source != other.source:
        return _("measured by %(one)s, then by %(other)s", one=remark(one.source), other=remark(other.source))
    if one.version != other.version:
        return _("method %(one)s, then %(other)s", one=one.version, other=other.version)
    if set(before.modes) != set(after.modes):
        return _("%(one)s mode, then %(other)s", one=mode_words(before.modes), other=mode_words(after.modes))
    if name in ERRORS and not _same_stiffness(before, after):
        return _("another stiffness")
    if name in (*ERRORS, "range_of_motion", "angle_max", "angle_min") and before.exercise != after.exercise:
        return _("another exercise (%(name)s)", name=exercise_words(before.exercise))
    return ""


def helped(past: Past) -> bool:
    """Whether the robot moved the hand, so that its range is not the patient's own."""
    return bool(HELPED & set(past.modes))


def stiffness_of(past: Past) -> float:
    """Mean stiffness over the driven joints, Nm/rad; NaN where it is not recorded."""
    known = [item.value for item in past.numbers if item.name == "stiffness" and item.value is not None]
    return sum(known) / len(known) if known else math.nan


def change(before: Past, after: Past, name: str, subject: str, bound: Bound) -> Change:
    """Judge a change.

    Args:
        before: The earlier session.
        after: The later one.
        name: Metric.
        subject: Joint, digit or "whole".
        bound: Minimal detectable change of this set-up.
    """
    hindrance = comparable(before, after, name, subject)
    one, other = before.number(name, subject), after.number(name, subject)
    if hindrance or one is None or other is None or one.value is None or other.value is None:
        return Change(math.nan, "not measurable", math.nan, hindrance)
    difference = other.value - one.value
    least, why = _least(one, other, bound(name, subject, other.source))
    if not math.isfinite(least):
        return Change(difference, "not measurable", math.nan, why)
    return Change(difference, "real" if abs(difference) > least else "below MDC", least, why)


def _least(one: Kept, other: Kept, known: float | None) -> tuple[float, str]:
    """The larger of the set-up's own MDC and what both intervals allow."""
    sensors = math.hypot(*(_half(item) for item in (one, other)))
    within = sensors if math.isfinite(sensors) else 0.0
    if known is not None and math.isfinite(known):
        return max(known, within), ""
    published = published_bound(one)
    if published is None:
        return math.nan, _("nobody measured how repeatable this number is")
    why = _("MDC as published for such measurements: this set-up's own was not measured")
    return max(published, within), why


def published_bound(item: Kept) -> float | None:
    """Least change that such a measurement was published to detect, SI units; None where there is none.

    Angles: 5 degrees is the best of 3-D capture (5 to 12, Reissner 2019); without markers 22.5 degrees, the
    error of a camera alone at its worst joint (Sensors 25:5716). Others: the upper end of the smallest real
    difference (doi 10.1186/s12984-020-00748-5, table 3), a share of the value.
    """
    if definition(item.name).unit == "rad" and item.name not in ERRORS:
        bare = any(word in item.source for word in _BARE_CAMERA)
        return math.radians(22.5) if bare else math.radians(5.0)
    share = _SMALLEST_SHARE.get(item.name)
    return None if share is None or item.value is None else share * abs(item.value)


def _half(item: Kept) -> float:
    return math.nan if item.low is None or item.high is None else (item.high - item.low) / 2.0


def _same_stiffness(before: Past, after: Past) -> bool:
    one, other = stiffness_of(before), stiffness_of(after)
    return abs(one - other) <= SAME_STIFFNESS * max(one, other)
