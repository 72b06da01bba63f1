"""From a take to a reference: a smooth path of the driven joints, inside the patient's limits."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rehab_app.hand.subject import on_side
from rehab_app.recording.take import SHORTEST_S, HandMotion, too_short
from rehab_app.therapy.reference_notes import clip_notes, gap_notes, trim_notes
from rehab_app.therapy.reference_retiming import Retimed, retime
from rehab_app.therapy.reference_speed import fastest
from rehab_app.therapy.smoothing import smooth, within
from robot_iface.kinematics import DIP_PER_PIP, HandGeometry, forward
from robot_iface.motion import QuinticPath
from robot_iface.types import Limits, ReferencePath, joint_index
from sessions.errors import Refused
from sessions.records import DIGITS, FINGERS, JOINTS, Side
from sessions.records.fields import Float64, Int64

JERK_RAD_S3 = 20.0
"""Usual jerk of a therapist's joint; robot.md's range is 15 to 40."""
STILL_RAD_S = float(np.deg2rad(4.0))
"""Speed of the fastest driven joint below which the hand is still."""

_GRID_S = 0.02
_LEAD_S = 0.4  # kept of a still beginning and end; added where the take begins or ends in motion
_STD_FLOOR_RAD = float(np.deg2rad(0.5))
_TIPS = [3, 7, 11, 15, 19]


@dataclass(frozen=True, slots=True)
class BuiltReference:
    """A reference and what became of the take on the way.

    Attributes:
        path: Path of the driven joints for this patient's side.
        residual_m: Retargeting budget by digit: rms distance between this patient's fingertip as the robot
            can move it and as all of the therapist's joint angles would place it.
        fastest_speed: Largest path speed, at most 1, at which every joint keeps its directed speed limits;
            not below the speed for which the path was timed.
        fastest_reason: What sets it: joint, speed, time and bound; empty when the whole speed is allowed.
        notes: What was slowed, trimmed, bridged, clipped or never seen, each one sentence.
        take_start_s: Time in the take at which the path begins; negative if a lead was added.
        take_t_s: Time in the take of each knot of the path, strictly increasing, shape (N,).
    """

    path: ReferencePath
    residual_m: dict[str, float]
    fastest_speed: float
    fastest_reason: str
    notes: tuple[str, ...]
    take_start_s: float
    take_t_s: Float64


def build_reference(
    motion: HandMotion,
    *,
    patient_geometry: HandGeometry,
    patient_side: Side,
    driven_joints: tuple[str, ...],
    limits: Limits,
    take_digest: str,
    speed: float | None = None,
    jerk_rad_s3: float = JERK_RAD_S3,
    trim_still: bool = True,
) -> BuiltReference:
    """Make a take playable for one patient.

    Joint angles mean the same on both sides, so that another side needs no more than the patient's geometry.
    Each sample counts by its covariance, a gap does not count and is bridged smoothly. DIP joints follow
    their PIP joints, joints that the device does not drive stay straight.

    Args:
        motion: The take.
        patient_geometry: The patient's hand.
        patient_side: Side of the patient's hand.
        driven_joints: The J joints of the device.
        limits: Bounds of those joints, in their order.
        take_digest: SHA-256 of the take.
        speed: Path speed at which it will be played, more than 0, at most 1: where that is too fast for a
            limit, and only there, the path is slowed. None keeps the therapist's timing, whatever the limits.
        jerk_rad_s3: Smoothness, 5 to 500.
        trim_still: Leave out all but 0.4 s of a still beginning and end.

    Raises:
        Refused: The take is shorter than a second, shows none of the driven joints, or moves one at more than
            20 times its speed limit.
    """
    if not 5.0 <= jerk_rad_s3 <= 500.0:
        raise Refused(
            "smoothing jerk", f"{jerk_rad_s3:g} rad/s^3", "5 to 500 rad/s^3", "choose in that range"
        )
    driven = joint_index(driven_joints)
    span_s = _playable_span(motion, driven, jerk_rad_s3, trim=trim_still)
    grid_s, wish = _wish(motion, span_s, jerk_rad_s3)
    bounded = _bounded(wish[:, driven], limits)
    path = ReferencePath(driven_joints, grid_s - grid_s[0], bounded, take_digest, patient_side)
    timed = Retimed(path, path.t_s, "") if speed is None else retime(path, limits, speed, span_s[0])
    fastest_speed, reason = fastest(QuinticPath(timed.path), limits)
    notes = (
        *((timed.note,) if timed.note else ()),
        *trim_notes(motion, span_s),
        *gap_notes(motion, driven),
        *clip_notes(driven_joints, wish[:, driven], limits),
    )
    residual_m = _residual(wish, bounded, driven_joints, on_side(patient_geometry, patient_side))
    return BuiltReference(
        path=timed.path,
        residual_m=residual_m,
        fastest_speed=fastest_speed,
        fastest_reason=reason,
        notes=notes,
        take_start_s=span_s[0],
        take_t_s=span_s[0] + timed.from_s,
    )


def whole_hand(driven_rad: Float64, driven_joints: tuple[str, ...]) -> Float64:
    """The 21 angles (N, 21) from the driven ones (N, J): DIP follows PIP, the rest stay straight."""
    joints = np.zeros((len(driven_rad), len(JOINTS)))
    joints[:, joint_index(driven_joints)] = driven_rad
    for finger in FINGERS:
        if f"{finger}_dip" not in driven_joints:
            pip = JOINTS.index(f"{finger}_pip")
            joints[:, pip + 1] = DIP_PER_PIP * joints[:, pip]
    return joints


def _wish(motion: HandMotion, span_s: tuple[float, float], jerk_rad_s3: float) -> tuple[Float64, Float64]:
    """Grid (K,) over a span of take time and smooth angles (K, 21) before any limit, at rest at both ends.

    Joints never seen stay straight. The span may reach beyond the samples: the path then leads in or out.
    """
    rows = (motion.t_s >= span_s[0]) & (motion.t_s <= span_s[1])
    t_s, joints = motion.t_s[rows], motion.joints_rad[rows]
    variance = np.diagonal(motion.joint_covariance_rad2[rows], axis1=1, axis2=2)
    std = np.sqrt(np.maximum(np.nan_to_num(variance, nan=1.0), _STD_FLOOR_RAD**2))
    steps = max(8, int(np.ceil((span_s[1] - span_s[0]) / _GRID_S)))
    grid_s = np.linspace(span_s[0], span_s[1], steps + 1)
    wish = np.zeros((steps + 1, len(JOINTS)))
    for joint in range(len(JOINTS)):
        if bool(np.isfinite(joints[:, joint]).any()):
            wish[:, joint] = smooth(t_s, joints[:, joint], std[:, joint], grid_s, jerk_rad_s3)
    return grid_s, wish


def _playable_span(
    motion: HandMotion, driven: Int64, jerk_rad_s3: float, *, trim: bool
) -> tuple[float, float]:
    """The span to play in take time: still ends shortened, moving ends led in and out, s."""
    shown = np.flatnonzero(np.isfinite(motion.joints_rad[:, driven]).any(axis=1))
    if not shown.size:
        names = ", ".join(JOINTS[index] for index in driven[:3])
        raise Refused(
            "take", "without driven joints", f"showing some of {names} ...", "record the hand again"
        )
    first_s, last_s = float(motion.t_s[shown[0]]), float(motion.t_s[shown[-1]])
    if last_s - first_s < SHORTEST_S:
        raise too_short(last_s - first_s)
    grid_s, wish = _wish(motion, (first_s - _LEAD_S, last_s + _LEAD_S), jerk_rad_s3)
    inside = (grid_s >= first_s) & (grid_s <= last_s)
    speed = np.abs(np.gradient(wish[:, driven], grid_s, axis=0)).max(axis=1)
    moving = grid_s[inside & (speed > STILL_RAD_S)]
    if not moving.size:
        return first_s, last_s
    start_s, end_s = float(moving[0]) - _LEAD_S, float(moving[-1]) + _LEAD_S
    if not trim:
        start_s, end_s = min(start_s, first_s), max(end_s, last_s)
    return (start_s, end_s) if end_s - start_s >= SHORTEST_S else (first_s, last_s)


def _bounded(wish_rad: Float64, limits: Limits) -> Float64:
    """The wish (K, J) kept inside the limits."""
    columns = [
        within(column, float(low), float(high))
        for column, low, high in zip(wish_rad.T, limits.q_min_rad, limits.q_max_rad, strict=True)
    ]
    return np.stack(columns, axis=1)


def _residual(
    wish: Float64, bounded: Float64, names: tuple[str, ...], geometry: HandGeometry
) -> dict[str, float]:
    """How far each fingertip on the path is from where all of the therapist's angles put it, rms, m."""
    asked = forward(geometry, wish).landmarks_m[:, _TIPS]
    played = forward(geometry, whole_hand(bounded, names)).landmarks_m[:, _TIPS]
    rms = np.sqrt(((asked - played) ** 2).sum(axis=2).mean(axis=0))
    return {digit: float(value) for digit, value in zip(DIGITS, rms, strict=True)}
