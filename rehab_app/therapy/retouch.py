"""Retouching a take: trim, smooth, slow, scale. Each operation makes a new motion and says what it did."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TypeAlias

import msgspec
import numpy as np

from rehab_app.recording.take import SHORTEST_S, HandMotion
from rehab_app.therapy.angle_fit import fit_angles
from robot_iface.kinematics import JOINT_MAX_RAD, JOINT_MIN_RAD, forward
from sessions.errors import Refused
from sessions.records import DIGITS, JOINTS, digit_of
from sessions.records.fields import Float64, Int64

_TIPS = [3, 7, 11, 15, 19]
_GRID_S = 0.02
_EASE_S = 0.25  # in which slowing sets in and ends, inside its span
_FIRST_S = 0.3  # whose middle posture scaling is about
_SLACK_RAD = float(np.deg2rad(3.0))


class Trim(msgspec.Struct, frozen=True, tag="trim", forbid_unknown_fields=True):
    """Keep what lies between two times of the take, s."""

    start_s: float
    end_s: float


class Smooth(msgspec.Struct, frozen=True, tag="smooth", forbid_unknown_fields=True):
    """Smooth the whole movement; the usual jerk of a joint, rad/s^3: smaller is smoother."""

    jerk_rad_s3: float


class Slow(msgspec.Struct, frozen=True, tag="slow", forbid_unknown_fields=True):
    """Take ``factor`` times as long between two times of the take, s."""

    factor: float
    start_s: float
    end_s: float


class Scale(msgspec.Struct, frozen=True, tag="scale", forbid_unknown_fields=True):
    """Make the movement of a digit or joint larger or smaller about its first posture."""

    subject: str
    factor: float


Operation: TypeAlias = Trim | Smooth | Slow | Scale


@dataclass(frozen=True, slots=True)
class Retouched:
    """A motion after some operations.

    Attributes:
        motion: The new motion; the one it was made from is untouched.
        sentences: What each operation did, in order.
    """

    motion: HandMotion
    sentences: tuple[str, ...]


def retouch(motion: HandMotion, operations: tuple[Operation, ...]) -> Retouched:
    """Apply operations one after the other; times are those of the motion that each one meets.

    Raises:
        Refused: There is none, or one is out of its bounds.
    """
    if not operations:
        raise Refused("retouch", "without an operation", "one or more", "trim, smooth, slow or scale")
    sentences: list[str] = []
    for operation in operations:
        if isinstance(operation, Trim):
            motion, said = trim(motion, operation.start_s, operation.end_s)
        elif isinstance(operation, Smooth):
            motion, said = smooth(motion, operation.jerk_rad_s3)
        elif isinstance(operation, Slow):
            motion, said = slow(motion, operation.factor, operation.start_s, operation.end_s)
        else:
            motion, said = scale(motion, operation.subject, operation.factor)
        sentences.append(said)
    return Retouched(motion, tuple(sentences))


def trim(motion: HandMotion, start_s: float, end_s: float) -> tuple[HandMotion, str]:
    """Keep what lies between two times.

    Raises:
        Refused: The times are not in the take, or leave less than a second.
    """
    _check_span(motion, start_s, end_s, SHORTEST_S)
    rows = np.flatnonzero((motion.t_s >= start_s) & (motion.t_s <= end_s))
    if rows.size < 2 or motion.t_s[rows[-1]] - motion.t_s[rows[0]] < SHORTEST_S:
        raise _span("without samples", motion)
    kept = replace(
        motion,
        t_ns=motion.t_ns[rows],
        t_s=motion.t_s[rows] - motion.t_s[rows[0]],
        joints_rad=motion.joints_rad[rows],
        joint_covariance_rad2=motion.joint_covariance_rad2[rows],
        joint_status=motion.joint_status[rows],
        fingertips_palm_m=motion.fingertips_palm_m[rows],
        p_camera_palm_m=motion.p_camera_palm_m[rows],
        q_camera_palm_wxyz=motion.q_camera_palm_wxyz[rows],
        residual_m=motion.residual_m[rows],
    )
    return kept, f"Trimmed to {start_s:.2f} to {end_s:.2f} s."


def smooth(motion: HandMotion, jerk_rad_s3: float) -> tuple[HandMotion, str]:
    """Smooth the joint angles; gaps stay gaps and covariances as they were stated.

    Raises:
        Refused: The jerk is not 5 to 500 rad/s^3.
    """
    if not 5.0 <= jerk_rad_s3 <= 500.0:
        raise Refused(
            "smoothing jerk", f"{jerk_rad_s3:g} rad/s^3", "5 to 500 rad/s^3", "choose in that range"
        )
    steps = max(8, int(np.ceil(float(motion.t_s[-1]) / _GRID_S)))
    grid_s = np.linspace(0.0, float(motion.t_s[-1]), steps + 1)
    path = fit_angles(
        motion.t_s,
        motion.joints_rad,
        motion.joint_covariance_rad2,
        motion.geometry,
        grid_s,
        jerk_rad_s3=jerk_rad_s3,
        at_rest=False,
    )
    read = np.stack([np.interp(motion.t_s, grid_s, column) for column in path.T], axis=1)
    moved = np.where(np.isfinite(motion.joints_rad), read, np.nan)
    return _with_joints(motion, moved), f"Smoothed to a usual jerk of {jerk_rad_s3:g} rad/s^3."


def slow(motion: HandMotion, factor: float, start_s: float, end_s: float) -> tuple[HandMotion, str]:
    """Take longer between two times; it sets in and ends within a quarter of a second.

    Raises:
        Refused: The factor is not 1 to 10, or the times are not half a second apart in the take.
    """
    if not 1.0 <= factor <= 10.0:
        raise Refused("slowing factor", f"{factor:g}", "1 to 10", "choose in that range")
    _check_span(motion, start_s, end_s, 2.0 * _EASE_S)
    inside = np.clip(np.minimum(motion.t_s - start_s, end_s - motion.t_s) / _EASE_S, 0.0, 1.0)
    rate = 1.0 + (factor - 1.0) * inside**2 * (3.0 - 2.0 * inside)
    passed_s = 0.5 * (rate[1:] + rate[:-1]) * np.diff(motion.t_s)
    t_s = np.concatenate(([0.0], np.cumsum(passed_s)))
    t_ns: Int64 = motion.t_ns[0] + np.round(1e9 * t_s).astype(np.int64)
    slowed = replace(motion, t_ns=t_ns, t_s=1e-9 * (t_ns - t_ns[0]).astype(np.float64))
    return slowed, f"Slowed by {factor:g} from {start_s:.2f} to {end_s:.2f} s."


def scale(motion: HandMotion, subject: str, factor: float) -> tuple[HandMotion, str]:
    """Make the movement of a digit or joint larger or smaller about its first posture.

    Raises:
        Refused: There is no such digit or joint, the factor is not 0 to 2, or a joint would leave the range
            of healthy hands.
    """
    if not 0.0 <= factor <= 2.0:
        raise Refused("scaling factor", f"{factor:g}", "0 to 2", "choose in that range")
    columns = [row for row, name in enumerate(JOINTS) if subject in (name, digit_of(name))]
    if not columns:
        raise Refused("digit or joint", repr(subject), f"one of {', '.join(DIGITS)} or a joint", "name one")
    joints, shares = motion.joints_rad.copy(), np.ones(len(JOINTS))
    for column in columns:
        seen = np.flatnonzero(np.isfinite(joints[:, column]))
        if seen.size:
            early = seen[motion.t_s[seen] <= motion.t_s[seen[0]] + _FIRST_S]
            first = float(np.median(joints[early, column]))
            joints[:, column] = first + factor * (joints[:, column] - first)
            _check_range(column, motion, joints[:, column])
            shares[column] = max(factor, 0.1)
    covariance = motion.joint_covariance_rad2 * np.outer(shares, shares)
    scaled = replace(_with_joints(motion, joints), joint_covariance_rad2=covariance)
    return scaled, f"Scaled the movement of {subject} by {factor:g} about its first posture."


def _with_joints(motion: HandMotion, joints_rad: Float64) -> HandMotion:
    """The same motion with other angles, and the fingertips that belong to them."""
    tips = forward(motion.geometry, joints_rad).landmarks_m[:, _TIPS]
    return replace(motion, joints_rad=joints_rad, fingertips_palm_m=tips)


def _check_range(column: int, motion: HandMotion, angles: Float64) -> None:
    """Refuse angles beyond what a healthy joint, or the take itself, reaches."""
    seen = motion.joints_rad[:, column]
    low = min(float(JOINT_MIN_RAD[column]), float(np.nanmin(seen))) - _SLACK_RAD
    high = max(float(JOINT_MAX_RAD[column]), float(np.nanmax(seen))) + _SLACK_RAD
    worst = int(np.nanargmax(np.maximum(angles - high, low - angles)))
    if not low <= angles[worst] <= high:
        raise Refused(
            f"{JOINTS[column]} at {motion.t_s[worst]:.1f} s",
            f"{np.rad2deg(angles[worst]):.0f} deg",
            f"{np.rad2deg(low):.0f} to {np.rad2deg(high):.0f} deg",
            "scale by less",
        )


def _check_span(motion: HandMotion, start_s: float, end_s: float, least_s: float) -> None:
    inside = -1e-9 <= start_s and end_s <= float(motion.t_s[-1]) + 1e-9
    if not (inside and end_s - start_s >= least_s):
        raise _span(f"{start_s:g} to {end_s:g} s", motion, least_s)


def _span(value: str, motion: HandMotion, least_s: float = SHORTEST_S) -> Refused:
    bound = f"{least_s:g} s or longer within 0 to {float(motion.t_s[-1]):.2f} s"
    return Refused("span of the take", value, bound, "choose other times")
