"""From a take to a reference: a smooth path of the driven joints, inside the patient's limits."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rehab_app.hand.subject import on_side
from rehab_app.recording.take import SHORTEST_S, HandMotion, too_short
from rehab_app.therapy.reference_notes import clip_notes, gap_notes, trim_notes
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
_SPEED_MARGIN = 0.98
_TIPS = [3, 7, 11, 15, 19]


@dataclass(frozen=True, slots=True)
class BuiltReference:
    """A reference and what became of the take on the way.

    Attributes:
        path: Path of the driven joints for this patient's side.
        residual_m: Retargeting budget by digit: rms distance between this patient's fingertip as the robot
            can move it and as all of the therapist's joint angles would place it.
        fastest_speed: Largest path speed, at most 1, at which every joint keeps its directed speed limits.
        fastest_reason: What sets it: joint, speed, time and bound; empty when the whole speed is allowed.
        notes: What was trimmed, bridged, clipped or never seen, each one sentence.
        take_start_s: Time in the take at which the path begins; negative if a lead was added.
    """

    path: ReferencePath
    residual_m: dict[str, float]
    fastest_speed: float
    fastest_reason: str
    notes: tuple[str, ...]
    take_start_s: float


def build_reference(
    motion: HandMotion,
    *,
    patient_geometry: HandGeometry,
    patient_side: Side,
    driven_joints: tuple[str, ...],
    limits: Limits,
    take_digest: str,
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
        jerk_rad_s3: Smoothness, 5 to 500.
        trim_still: Leave out all but 0.4 s of a still beginning and end.

    Raises:
        Refused: The take is shorter than a second or shows none of the driven joints.
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
    fastest, reason = _fastest(path, limits)
    notes = (
        *trim_notes(motion, span_s),
        *gap_notes(motion, driven),
        *clip_notes(driven_joints, wish[:, driven], limits),
    )
    residual_m = _residual(wish, bounded, driven_joints, on_side(patient_geometry, patient_side))
    return BuiltReference(path, residual_m, fastest, reason, notes, span_s[0])


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


def _fastest(path: ReferencePath, limits: Limits) -> tuple[float, str]:
    """Largest path speed at which the spline keeps the directed speed limits, and what sets it."""
    spline = QuinticPath(path)
    s = np.arange(0.0, spline.duration_s, 0.25 * _GRID_S)
    speed = spline.sample(s, 1)
    ratio = np.maximum(speed / limits.flexion_speed_rad_s, -speed / limits.extension_speed_rad_s)
    row, joint = divmod(int(np.argmax(ratio)), ratio.shape[1])
    worst = float(ratio[row, joint])
    if worst <= 1.0:
        return 1.0, ""
    met = float(speed[row, joint])
    bounds = limits.flexion_speed_rad_s if met > 0 else limits.extension_speed_rad_s
    way = "flexion" if met > 0 else "extension"
    reason = (
        f"{path.joint_names[joint]} moves at {abs(np.rad2deg(met)):.0f} deg/s into {way} at {s[row]:.2f} s "
        f"of full speed, {np.rad2deg(bounds[joint]):.0f} deg/s are allowed"
    )
    return min(1.0, _SPEED_MARGIN / worst), reason


def _residual(
    wish: Float64, bounded: Float64, names: tuple[str, ...], geometry: HandGeometry
) -> dict[str, float]:
    """How far each fingertip on the path is from where all of the therapist's angles put it, rms, m."""
    asked = forward(geometry, wish).landmarks_m[:, _TIPS]
    played = forward(geometry, whole_hand(bounded, names)).landmarks_m[:, _TIPS]
    rms = np.sqrt(((asked - played) ** 2).sum(axis=2).mean(axis=0))
    return {digit: float(value) for digit, value in zip(DIGITS, rms, strict=True)}
