"""Opening, closing and rhythm of a recorded hand, as numbers with their lineage."""

from __future__ import annotations

import math

import numpy as np

from sessions.metrics.filtering import FILTER
from sessions.metrics.finger_bones import HandBones, bones_of
from sessions.metrics.hand_motion import HandMotion, main_angle
from sessions.metrics.hand_opening import held_distance, kapandji, palm_distance_m, tip_distance
from sessions.metrics.metric import Estimate, Metric, metric
from sessions.metrics.recording import Origin, seconds
from sessions.metrics.repetitions import Cycles
from sessions.metrics.rhythm import decrement, pauses
from sessions.records import DIGITS, FINGERS, Status
from sessions.records.fields import Float64

NO_BONES = "the file does not hold the hand's bones"
CREASE = "crease of the palm placed 12 mm palmar and 8 mm proximal of the knuckle"
NOT_TOUCH = "above 6 a weak measure of opposition"
_DISTANCES = (
    ("aperture", "thumb", "index"),
    ("span", "thumb", "little"),
    ("finger_spread", "index", "little"),
)


def opening_metrics(motion: HandMotion, subject_hand: str, origin: Origin) -> list[Metric]:
    """How wide the hand opened, how far the fingers closed to the palm, and the thumb's opposition.

    Args:
        motion: The hand.
        subject_hand: JSON of the hand in the header.
        origin: Which file.
    """
    lineage = origin.lineage((motion.topic,), motion.t_ns, FILTER)
    t_s, tips = seconds(motion.t_ns), motion.usable_tips()
    found: list[Metric] = []
    for name, one, other in _DISTANCES:
        distance, std = tip_distance(tips, motion.fingertip_std_m, one, other)
        flags = dict.fromkeys(filter(None, (motion.tip_flag(DIGITS.index(digit)) for digit in (one, other))))
        value = held_distance(t_s, distance, std, largest=True)
        found.append(metric(name, "whole", value, lineage, "; ".join(flags)))
    bones = bones_of(subject_hand)
    for finger in FINGERS:
        value = Estimate.missing(NO_BONES) if bones is None else _to_palm(motion, bones, finger, t_s, tips)
        flag = "; ".join(filter(None, (CREASE, motion.tip_flag(DIGITS.index(finger)))))
        found.append(metric("finger_to_palm", finger, value, lineage, flag))
    angles = np.where(motion.joint_status >= Status.ESTIMATED, motion.joints_rad, math.nan)
    reached = Estimate.missing(NO_BONES) if bones is None else kapandji(bones, tips, angles)
    return [*found, metric("kapandji", "whole", reached, lineage, NOT_TOUCH)]


def rhythm_metrics(motion: HandMotion, found: Cycles, origin: Origin) -> list[Metric]:
    """Decrement and pauses of the main movement."""
    lineage = origin.lineage((motion.topic,), motion.t_ns, FILTER)
    rest = pauses(seconds(motion.t_ns), main_angle(motion), found.strokes_s)
    rows = (
        ("amplitude_decrement", decrement(found.stroke_rad)),
        ("pauses", rest.count),
        ("longest_pause", rest.longest),
    )
    return [metric(name, "whole", value, lineage) for name, value in rows]


def _to_palm(motion: HandMotion, bones: HandBones, finger: str, t_s: Float64, tips: Float64) -> Estimate:
    digit = DIGITS.index(finger)
    distance = palm_distance_m(bones, finger, tips[:, digit])
    return held_distance(t_s, distance, motion.fingertip_std_m[:, digit], largest=False)
