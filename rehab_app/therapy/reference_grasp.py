"""From the way to a grasp to a reference: open, grasp, hold, open again."""

from __future__ import annotations

import hashlib

import numpy as np

from rehab_app.grasp.hand import GraspHand
from rehab_app.grasp.spiral import GraspPath
from rehab_app.grasp.timing import there_and_back
from rehab_app.hand.retarget import ROBOT_JOINTS
from rehab_app.hand.retarget_range import within
from rehab_app.hand.subject import on_side
from rehab_app.therapy.reference import BuiltReference
from rehab_app.therapy.reference_notes import posture_notes
from rehab_app.therapy.reference_place import Placed, place
from rehab_app.therapy.reference_retiming import Retimed, retime
from rehab_app.therapy.reference_speed import fastest
from robot_iface.kinematics.dlr_hit import dlr_hit_hand, hand_points
from robot_iface.motion import QuinticPath
from robot_iface.types import Capabilities, Limits, ReferencePath
from sessions.errors import Refused
from sessions.records import DIGITS, JOINTS, Side
from sessions.records.fields import Float64

_GRID_S = 0.02


def reference_from_grasp(
    way: GraspPath,
    hand: GraspHand,
    *,
    patient_side: Side,
    device: Capabilities,
    limits: Limits,
    closing_s: float = 3.0,
    hold_s: float = 1.0,
    speed: float | None = None,
) -> BuiltReference:
    """Make a grasp playable: passively along its way, or as the goal that is shown.

    Args:
        way: From the open hand to the posture (``spiral_path``).
        hand: The hand that it was made for: the patient's, or the robot's.
        patient_side: Side of the patient's hand.
        device: What plays it; a person's grasp is retargeted to a robot that nobody wears.
        limits: Bounds of the device's joints.
        closing_s: Time from open to the grasp, 0.5 to 30 s; opening takes as long.
        hold_s: Time in the grasp, 0 to 60 s.
        speed: Path speed at which it will be played; where that is too fast for a limit, and only there, the
            path is slowed. None keeps the timing.

    Returns:
        The reference; its ``take_digest`` is the SHA-256 of the way's angles, as there is no take.

    Raises:
        Refused: A time is out of bounds, or the robot's own grasp is to be played on a person's hand.
    """
    t_s, wish = there_and_back(way, closing_s, hold_s, _GRID_S)
    placed = _placed(wish, hand, patient_side, device, limits, t_s)
    digest = hashlib.sha256(np.ascontiguousarray(way.joints_rad).tobytes()).hexdigest()
    path = ReferencePath(device.joint_names, t_s, placed.q_rad, digest, patient_side)
    timed = Retimed(path, path.t_s, "") if speed is None else retime(path, limits, speed)
    fastest_speed, reason = fastest(QuinticPath(timed.path), limits)
    return BuiltReference(
        path=timed.path,
        residual_m=placed.residual_m,
        fastest_speed=fastest_speed,
        fastest_reason=reason,
        notes=tuple(
            note.replace("of the take", "of the way") for note in (timed.note, *placed.notes) if note
        ),
        take_start_s=0.0,
        take_t_s=timed.from_s,
    )


def _placed(
    wish: Float64, hand: GraspHand, side: Side, device: Capabilities, limits: Limits, t_s: Float64
) -> Placed:
    if hand.person is not None:
        return place(wish, on_side(hand.person, side), device.joint_names, limits, device, t_s)
    if device.chain != "dlr-hit-ii" or device.joint_names != ROBOT_JOINTS:
        raise Refused(
            "grasp",
            f"made for the {hand.name}",
            f"made for a person's hand, as {device.name} moves one",
            "ask for --hand human:length=L",
        )
    asked = wish[:, [JOINTS.index(name) for name in ROBOT_JOINTS]]
    low, high = np.maximum(limits.q_min_rad, device.q_min_rad), np.minimum(limits.q_max_rad, device.q_max_rad)
    bounded = np.stack(
        [within(column, float(a), float(b)) for column, a, b in zip(asked.T, low, high, strict=True)], axis=1
    )
    robot = dlr_hit_hand()
    shown, played = (hand_points(robot, angles.reshape(-1, 5, 3))[:, :, 3] for angles in (asked, bounded))
    rms = np.sqrt(((shown - played) ** 2).sum(axis=2).mean(axis=0))
    budget = {digit: float(value) for digit, value in zip(DIGITS, rms, strict=True)}
    return Placed(bounded, budget, posture_notes(ROBOT_JOINTS, asked, low, high, t_s))
