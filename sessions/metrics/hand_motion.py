"""Numbers that a moving hand has whether or not somebody is to be followed: range, smoothness, strokes."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sessions.metrics.filtering import FILTER, cut_hz
from sessions.metrics.metric import Estimate, Metric, metric
from sessions.metrics.motion_range import joint_range, total_active_motion
from sessions.metrics.norms import NORM_WORDS, active_motion_share, norm_of, share_of
from sessions.metrics.recording import Origin, digit_with_all_joints, seconds
from sessions.metrics.repetitions import Cycles, cycles, main_movement
from sessions.metrics.stroke_noise import noise_reach, smoothness_floor
from sessions.metrics.strokes import StrokeValues, over_strokes, stroke_values
from sessions.records import DIGITS, FINGERS, JOINTS, Status, Topic
from sessions.records.fields import Float64, Int64, UInt8

FLEXION = np.array([0.0 if joint.endswith("abduction") else 1.0 for joint in JOINTS])
MOSTLY = 0.95
FLOOR_SEED = 2015
FEWEST_BENDS = 20
ESTIMATED = "estimated from other joints, not measured"
EFFORT = "the take need not show full effort"
NOISE_UNKNOWN = "the interval knows nothing of the measurement's noise, which is not stated"
ARM = "reliability is known for reaching arms, not for fingers"


@dataclass(frozen=True, slots=True)
class HandMotion:
    """A hand over time, in the palm frame.

    Attributes:
        topic: Where it was read.
        t_ns: Times, shape (N,).
        joints_rad: Angles, shape (N, 21).
        joint_std_rad: Their standard deviations, shape (N, 21).
        joint_status: Their status, shape (N, 21).
        fingertips_m: Fingertips, shape (N, 5, 3).
        fingertip_std_m: Standard deviation per axis, shape (N, 5).
    """

    topic: Topic
    t_ns: Int64
    joints_rad: Float64
    joint_std_rad: Float64
    joint_status: UInt8
    fingertips_m: Float64
    fingertip_std_m: Float64

    def at(self, rows: Int64) -> HandMotion:
        """The hand at some row numbers."""
        columns = (self.joints_rad, self.joint_std_rad, self.joint_status)
        tips = (self.fingertips_m, self.fingertip_std_m)
        return HandMotion(
            self.topic, at_rows(self.t_ns, rows), *(at_rows(column, rows) for column in (*columns, *tips))
        )

    def usable_joints(self) -> tuple[Float64, tuple[str, ...]]:
        """Angles (N, 21) with NaN where they may not be used, and what must be said of each joint."""
        measured = (self.joint_status == Status.MEASURED) & np.isfinite(self.joints_rad)
        number = measured.sum(axis=0)
        estimated = (self.joint_status == Status.ESTIMATED) & (number == 0)
        guessed = estimated.any(axis=0).tolist()
        flags = [
            _seen(count / len(measured)) if count else ESTIMATED if guess else ""
            for count, guess in zip(number.tolist(), guessed, strict=True)
        ]
        return np.where(measured | estimated, self.joints_rad, np.nan), tuple(flags)

    def measured_joints(self) -> Float64:
        """Angles with NaN wherever they were not measured, shape (N, 21)."""
        return np.where(self.joint_status == Status.MEASURED, self.joints_rad, np.nan)

    def usable_tips(self) -> Float64:
        """Fingertips with NaN where a joint of the digit was lost, shape (N, 5, 3)."""
        there = digit_with_all_joints(self.joint_status, Status.ESTIMATED)
        return np.where(there[..., None], self.fingertips_m, np.nan)

    def tip_flag(self, digit: int) -> str:
        """What must be said of a fingertip that rests on estimated joints; empty if nothing."""
        if not len(self.joint_status):
            return ""
        share = 1.0 - float(digit_with_all_joints(self.joint_status, Status.MEASURED)[:, digit].mean())
        return (
            ""
            if share <= 1.0 - MOSTLY
            else f"a joint of the digit was estimated in {share:.0%} of the frames"
        )


def _seen(share: float) -> str:
    return "" if share >= MOSTLY else f"measured in {share:.0%} of the frames"


def at_rows(column: NDArray[Any], rows: Int64) -> NDArray[Any]:
    """Some rows of a column; the column itself where these are all of them in their order."""
    return column if np.array_equal(rows, np.arange(len(column))) else column[rows]


def range_metrics(motion: HandMotion, origin: Origin) -> list[Metric]:
    """Range, smallest and largest angle of each of the 21 joints."""
    found: list[Metric] = []
    t_s = seconds(motion.t_ns)
    lineage = origin.lineage((motion.topic,), motion.t_ns, FILTER)
    angles, flags = motion.usable_joints()
    for column, (joint, flag) in enumerate(zip(JOINTS, flags, strict=True)):
        extent = joint_range(t_s, angles[:, column].copy(), motion.joint_std_rad[:, column])
        for name, value in zip(
            ("range_of_motion", "angle_min", "angle_max"),
            (extent.width, extent.low, extent.high),
            strict=True,
        ):
            found.append(metric(name, joint, value, lineage, flag))
        norm = norm_of(joint)
        if norm is not None:
            of_norm = origin.lineage((motion.topic,), motion.t_ns, f"{FILTER}; {NORM_WORDS}")
            share = share_of(extent.width, Estimate(norm, (norm, norm)))
            found.append(metric("range_share", joint, share, of_norm, flag))
    return found


def main_angle(motion: HandMotion, rows: NDArray[np.bool_] | None = None) -> Float64:
    """The main movement as one angle, shape (N,), rad.

    Args:
        motion: The hand.
        rows: Boolean mask (N,) of rows that count; all where None.
    """
    angles = np.where(motion.joint_status >= Status.ESTIMATED, motion.joints_rad, np.nan)
    movement = main_movement(angles, FLEXION)
    if rows is not None:
        movement = np.where(rows, movement, np.nan)
    return movement


def main_cycles(motion: HandMotion, rows: NDArray[np.bool_] | None = None) -> Cycles:
    """Cycles of the main movement; arguments as of ``main_angle``."""
    return cycles(seconds(motion.t_ns), main_angle(motion, rows))


def stroke_metrics(motion: HandMotion, strokes_s: Float64, origin: Origin) -> list[Metric]:
    """Smoothness, time, speed and path of each fingertip over the strokes (S, 2)."""
    found: list[Metric] = []
    t_s, tips = seconds(motion.t_ns), motion.usable_tips()
    rng = np.random.default_rng(FLOOR_SEED)
    for column, digit in enumerate(DIGITS):
        noise_m = _noise_m(motion.fingertip_std_m[:, column], tips[:, column])
        values = stroke_values(t_s, tips[:, column], strokes_s, noise_m)
        lineage = origin.lineage((motion.topic,), motion.t_ns, _filter_of(values))
        reach = noise_reach(values, noise_m, rng)
        flags = (motion.tip_flag(column), "" if math.isfinite(noise_m) else NOISE_UNKNOWN)
        for name, remark in _STROKE_ROWS:
            estimate = over_strokes([getattr(item, name) for item in values], reach[name])
            found.append(metric(name, digit, estimate, lineage, "; ".join(filter(None, (*flags, remark)))))
        floors = smoothness_floor(values, noise_m, rng)
        for name, floor in zip(("sparc_floor", "ldlj_floor"), floors, strict=True):
            found.append(metric(name, digit, floor, lineage))
    return found


def active_motion_metrics(motion: HandMotion, origin: Origin, refusal: str = "") -> list[Metric]:
    """Total active motion of the four fingers, at the one instant of the fullest fist and opening.

    Args:
        motion: The hand.
        origin: Which file.
        refusal: Why it would not be active motion (the robot moved the hand); empty if it was.
    """
    lineage = origin.lineage((motion.topic,), motion.t_ns)
    measured = motion.measured_joints()
    found: list[Metric] = []
    for finger in FINGERS:
        columns = [JOINTS.index(f"{finger}_{part}") for part in ("mcp_flexion", "pip", "dip")]
        angles = measured[:, columns]
        whole = np.isfinite(angles).all(axis=1)
        if refusal or not bool(whole.any()):
            value = Estimate.missing(refusal or "MCP, PIP and DIP were never measured together")
        else:
            total = np.where(whole, angles.sum(axis=1), np.nan)
            fist, open_ = int(np.nanargmax(total)), int(np.nanargmin(total))
            std = motion.joint_std_rad[:, columns]
            value = total_active_motion(angles[fist], angles[open_], std[fist], std[open_])
        share, words = active_motion_share(value)
        found.append(metric("total_active_motion", finger, value, lineage, EFFORT))
        found.append(metric("active_motion_share", finger, share, lineage, f"{words}; {EFFORT}"))
    return found


_STROKE_ROWS = (("sparc", ARM), ("ldlj", ARM), ("movement_time", ""), ("peak_speed", ""), ("path_ratio", ""))


def _filter_of(values: list[StrokeValues]) -> str:
    if not values:
        return FILTER
    rate = values[0].rate_hz
    return f"{FILTER.replace('6 Hz', f'{cut_hz(rate):.3g} Hz')}, {rate:.3g} samples/s"


def _noise_m(std_m: Float64, tip_m: Float64) -> float:
    """Noise from frame to frame: what is stated, or less where second differences (N - 2, 3) show less.

    An error that stays (a bone's length, a marker's place) is in what is stated, and does not make a
    movement look rough.
    """
    known = std_m[np.isfinite(std_m)]
    if not known.size:
        return math.nan
    stated = float(np.median(known))
    bends = np.diff(tip_m, 2, axis=0)
    bends = bends[np.isfinite(bends).all(axis=1)]
    if len(bends) < FEWEST_BENDS:
        return stated
    return min(stated, float(np.sqrt(np.median(np.mean(bends**2, axis=1)) / 6.0)))
