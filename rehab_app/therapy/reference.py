"""From a take to a reference: a smooth path of the driven joints, inside the patient's limits."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rehab_app.hand.subject import on_side
from rehab_app.recording.take import SHORTEST_S, HandMotion, too_short
from rehab_app.therapy.angle_fit import fit_angles
from rehab_app.therapy.reference_notes import gap_notes, stillness_notes, trim_notes
from rehab_app.therapy.reference_place import Placed, place
from rehab_app.therapy.reference_retiming import MOST, Retimed, retime
from rehab_app.therapy.reference_speed import fastest
from robot_iface.kinematics import HandGeometry
from robot_iface.motion import QuinticPath
from robot_iface.types import Capabilities, Limits, ReferencePath, joint_index
from sessions.errors import Refused
from sessions.records import JOINTS, Side
from sessions.records.fields import Float64, Int64

CALM_JERKS_RAD_S3 = (60.0, 20.0)
"""Smoothness of a movement that would be too fast for the limits as the take shows it, tried in turn."""
STILL_RAD_S = float(np.deg2rad(4.0))
"""Speed of the fastest driven joint below which the hand is still."""

_GRID_S = 0.02
_LEAD_S = 0.4  # kept of a still beginning and end; added where the take begins or ends in motion
_TOO_FAST = 1.0 / (0.95 * MOST)  # path speed below which slowing it locally cannot help
_CALM_NOTE = (
    "As recorded, the movement is too fast or too unsteady for the limits: it was smoothed strongly "
    "(jerk {:g} rad/s^3)."
)


@dataclass(frozen=True, slots=True)
class BuiltReference:
    """A reference and what became of the take on the way.

    Attributes:
        path: Path of the driven joints for this patient's side.
        residual_m: Retargeting budget by digit: rms distance between this patient's fingertip as the robot
            can move it and as all of the therapist's joint angles would place it; on a robot with a chain of
            its own, between its fingertip and the like place at its size.
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
    jerk_rad_s3: float | None = None,
    trim_still: bool = True,
    device: Capabilities | None = None,
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
        jerk_rad_s3: Usual jerk of every joint, 5 to 500: smaller is smoother. None: as the take says.
        trim_still: Leave out all but 0.4 s of a still beginning and end.
        device: The device; None for one that is worn and moves the hand's own joints. For one with a chain of
            its own the movement is retargeted, and what it cannot make is noted.

    Raises:
        Refused: The take is shorter than a second, shows none of the driven joints, or moves one at more than
            20 times its speed limit.
    """
    if jerk_rad_s3 is not None and not 5.0 <= jerk_rad_s3 <= 500.0:
        raise Refused(
            "smoothing jerk", f"{jerk_rad_s3:g} rad/s^3", "5 to 500 rad/s^3", "choose in that range"
        )
    geometry = on_side(patient_geometry, patient_side)
    driven = _shown(driven_joints, device)
    span_s = _playable_span(motion, driven, jerk_rad_s3, trim=trim_still)
    calm = () if jerk_rad_s3 is not None else CALM_JERKS_RAD_S3
    path, placed = _fitted(motion, span_s, jerk_rad_s3, take_digest, driven_joints, geometry, limits, device)
    smoothed: tuple[str, ...] = ()
    for jerk in calm:
        if fastest(QuinticPath(path), limits)[0] >= _TOO_FAST:
            break
        path, placed = _fitted(motion, span_s, jerk, take_digest, driven_joints, geometry, limits, device)
        smoothed = (_CALM_NOTE.format(jerk),)
    timed = Retimed(path, path.t_s, "") if speed is None else retime(path, limits, speed, span_s[0])
    fastest_speed, reason = fastest(QuinticPath(timed.path), limits)
    timing = (timed.note,) if timed.note else ()
    still = stillness_notes(driven_joints, timed.path.q_rad)
    return BuiltReference(
        path=timed.path,
        residual_m=placed.residual_m,
        fastest_speed=fastest_speed,
        fastest_reason=reason,
        notes=(
            *still,
            *timing,
            *smoothed,
            *trim_notes(motion, span_s),
            *gap_notes(motion, driven),
            *placed.notes,
        ),
        take_start_s=span_s[0],
        take_t_s=span_s[0] + timed.from_s,
    )


def _fitted(
    motion: HandMotion,
    span_s: tuple[float, float],
    jerk_rad_s3: float | None,
    take_digest: str,
    driven_joints: tuple[str, ...],
    geometry: HandGeometry,
    limits: Limits,
    device: Capabilities | None,
) -> tuple[ReferencePath, Placed]:
    """The path in the therapist's own timing, for one smoothness."""
    grid_s, wish = _wish(motion, span_s, jerk_rad_s3)
    placed = place(wish, geometry, driven_joints, limits, device, grid_s)
    return ReferencePath(driven_joints, grid_s - grid_s[0], placed.q_rad, take_digest, geometry.side), placed


def _shown(driven_joints: tuple[str, ...], device: Capabilities | None) -> Int64:
    """The joints of the take that matter for a device: its own, or on another chain all that bend."""
    if device is None or device.chain == "hand":
        return joint_index(driven_joints)
    return np.array([row for row, name in enumerate(JOINTS) if "abduction" not in name], dtype=np.int64)


def _wish(
    motion: HandMotion, span_s: tuple[float, float], jerk_rad_s3: float | None
) -> tuple[Float64, Float64]:
    """Grid (K,) over a span of take time and smooth angles (K, 21) before any limit, at rest at both ends.

    Joints never seen stay straight. The span may reach beyond the samples: the path then leads in or out.
    """
    rows = (motion.t_s >= span_s[0]) & (motion.t_s <= span_s[1])
    steps = max(8, int(np.ceil((span_s[1] - span_s[0]) / _GRID_S)))
    grid_s = np.linspace(span_s[0], span_s[1], steps + 1)
    wish = fit_angles(
        motion.t_s[rows],
        motion.joints_rad[rows],
        motion.joint_covariance_rad2[rows],
        motion.geometry,
        grid_s,
        jerk_rad_s3=jerk_rad_s3,
    )
    return grid_s, wish


def _playable_span(
    motion: HandMotion, driven: Int64, jerk_rad_s3: float | None, *, trim: bool
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
    rough = CALM_JERKS_RAD_S3[0] if jerk_rad_s3 is None else jerk_rad_s3
    grid_s, wish = _wish(motion, (first_s - _LEAD_S, last_s + _LEAD_S), rough)
    inside = (grid_s >= first_s) & (grid_s <= last_s)
    speed = np.abs(np.gradient(wish[:, driven], grid_s, axis=0)).max(axis=1)
    moving = grid_s[inside & (speed > STILL_RAD_S)]
    if not moving.size:
        return first_s, last_s
    start_s, end_s = float(moving[0]) - _LEAD_S, float(moving[-1]) + _LEAD_S
    if not trim:
        start_s, end_s = min(start_s, first_s), max(end_s, last_s)
    return (start_s, end_s) if end_s - start_s >= SHORTEST_S else (first_s, last_s)
