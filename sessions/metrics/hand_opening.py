"""How wide the hand opens and how far it closes, and Kapandji's opposition."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from scipy import ndimage

from sessions.metrics.filtering import low_pass
from sessions.metrics.finger_bones import HandBones, finger_points_m
from sessions.metrics.metric import Z95, Estimate
from sessions.metrics.spans import uniform_spans
from sessions.records import DIGITS
from sessions.records.fields import Float64

HELD_S = 0.1
TOUCH_M = 0.016
"""Tips lie inside the pulps, some 9 mm deep in the thumb and 7 mm in a finger: nearer, they touch."""
PALM_SKIN_M = 0.012
"""How far palmar of the knuckles' centres the skin of the distal crease lies."""
CREASE_BACK_M = 0.008
"""How far the distal palmar crease lies towards the wrist of the little finger's knuckle."""
LOCATIONS = (
    "side of the index finger's middle phalanx",
    "side of its distal phalanx",
    "tip of the index finger",
    "tip of the middle finger",
    "tip of the ring finger",
    "tip of the little finger",
    "DIP crease of the little finger",
    "its PIP crease",
    "its MCP crease",
    "the distal palmar crease",
)
"""Kapandji's places 1 to 10 (PMID 3963909)."""


def held_distance(t_s: Float64, distance_m: Float64, std_m: Float64, *, largest: bool) -> Estimate:
    """Largest or smallest distance that was held for 0.1 s after the filter.

    Args:
        t_s: Times, shape (N,).
        distance_m: Distance, shape (N,), NaN where not measured.
        std_m: Its standard deviation, shape (N,), NaN where unknown: then no interval.
        largest: Which end.
    """
    ends: list[float] = []
    for span in uniform_spans(t_s, distance_m):
        smooth = low_pass(span.values, span.rate_hz)
        window = round(HELD_S * span.rate_hz) + 1
        held = (ndimage.minimum_filter1d if largest else ndimage.maximum_filter1d)(smooth, window)
        inner = held[window // 2 : held.size - window // 2]
        if inner.size:
            ends.append(float(inner.max() if largest else inner.min()))
    if not ends:
        return Estimate.missing("never measured for 0.3 s without a gap")
    value = max(0.0, max(ends) if largest else min(ends))
    known = std_m[np.isfinite(distance_m)]
    if not bool(np.isfinite(known).all()):
        return Estimate(value)
    half = Z95 * float(np.median(known))
    return Estimate(value, (max(0.0, value - half), value + half))


def tip_distance(tips_m: Float64, std_m: Float64, one: str, other: str) -> tuple[Float64, Float64]:
    """Distance of two fingertips and its standard deviation, each (N,).

    Args:
        tips_m: Fingertips, shape (N, 5, 3).
        std_m: Standard deviation per axis, shape (N, 5).
        one: A digit.
        other: Another.
    """
    first, second = DIGITS.index(one), DIGITS.index(other)
    distance = np.linalg.norm(tips_m[:, first] - tips_m[:, second], axis=1)
    return distance, np.hypot(std_m[:, first], std_m[:, second])


def palm_distance_m(bones: HandBones, finger: str, tips_m: Float64) -> Float64:
    """Distance of a fingertip from the crease of the palm before its knuckle, shape (N,).

    Args:
        bones: The hand's bones; the crease is taken 12 mm palmar and 8 mm towards the wrist of the knuckle.
        finger: Index to little.
        tips_m: Its tip in the palm frame, shape (N, 3).
    """
    distance: Float64 = np.linalg.norm(tips_m - _crease_m(bones, finger), axis=1)
    return distance


def kapandji(bones: HandBones, tips_m: Float64, joints_rad: Float64) -> Estimate:
    """Kapandji's opposition, 0 to 10: the farthest place that the thumb's tip came within 16 mm of.

    Args:
        bones: The hand's bones.
        tips_m: All five tips in the palm frame, shape (N, 5, 3), NaN where not measured.
        joints_rad: All joints, shape (N, 21), NaN where not measured.
    """
    reached: Mapping[int, Float64] = _distances(bones, tips_m, joints_rad)
    known = {place: values[np.isfinite(values)] for place, values in reached.items()}
    if not any(values.size for values in known.values()):
        return Estimate.missing("thumb and fingers were never measured together")
    near = {place: float(values.min()) for place, values in known.items() if values.size}
    touched = [place for place, distance in near.items() if distance <= TOUCH_M]
    sure = [place for place, distance in near.items() if distance <= 0.5 * TOUCH_M]
    maybe = [place for place, distance in near.items() if distance <= 1.5 * TOUCH_M]
    low, value, high = (float(max(places, default=0)) for places in (sure, touched, maybe))
    unseen = len(LOCATIONS) - len(near)
    remark = f"; {unseen} places were not measured" if unseen else ""
    return Estimate(value, (low, high), f"from landmarks within 16 mm, not from touch{remark}")


def _distances(bones: HandBones, tips_m: Float64, joints_rad: Float64) -> dict[int, Float64]:
    """Distance of the thumb's tip from each of the places 1 to 10, (N,) each."""
    thumb = tips_m[:, 0]
    index = finger_points_m(bones, "index", tips_m[:, 1], joints_rad)
    little = finger_points_m(bones, "little", tips_m[:, 4], joints_rad)
    places = [
        0.5 * (index[:, 1] + index[:, 2]),
        0.5 * (index[:, 2] + index[:, 3]),
        *(tips_m[:, digit] for digit in range(1, 5)),
        little[:, 2],
        little[:, 1],
        np.where(
            np.isfinite(little[:, :1, 0]), bones.bases_m[4] + np.array([PALM_SKIN_M, 0.0, 0.0]), math.nan
        ),
        np.where(np.isfinite(little[:, :1, 0]), _crease_m(bones, "little"), math.nan),
    ]
    return {place: np.linalg.norm(thumb - at, axis=1) for place, at in enumerate(places, start=1)}


def _crease_m(bones: HandBones, finger: str) -> Float64:
    crease: Float64 = bones.bases_m[DIGITS.index(finger)] + np.array([PALM_SKIN_M, 0.0, -CREASE_BACK_M])
    return crease
