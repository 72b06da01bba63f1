"""A movement of a whole hand placed on a device: inside ranges and hulls, or on a chain of its own."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rehab_app.hand.retarget import ROBOT_JOINTS, retarget
from rehab_app.hand.retarget_range import within
from rehab_app.therapy.reference_clearance import keep_clearance
from rehab_app.therapy.reference_hulls import into_hulls
from rehab_app.therapy.reference_notes import clip_notes, posture_notes
from robot_iface.kinematics import DIP_PER_PIP, HandGeometry, forward
from robot_iface.types import Capabilities, Limits, joint_index
from sessions.errors import Refused
from sessions.records import DIGITS, FINGERS, JOINTS
from sessions.records.fields import Float64

_TIPS = [3, 7, 11, 15, 19]


@dataclass(frozen=True, slots=True)
class Placed:
    """A movement as a device can make it.

    Attributes:
        q_rad: Angles of its J joints, strictly inside their limits, shape (K, J).
        residual_m: By digit, rms distance of the fingertip from where it was shown.
        notes: What the device or the limits do not allow, each one sentence.
    """

    q_rad: Float64
    residual_m: dict[str, float]
    notes: tuple[str, ...]


def place(
    wish_rad: Float64,
    geometry: HandGeometry,
    names: tuple[str, ...],
    limits: Limits,
    device: Capabilities | None,
    take_s: Float64,
) -> Placed:
    """Place a movement on a device.

    Args:
        wish_rad: Angles of the whole hand, shape (K, 21).
        geometry: The patient's hand.
        names: The device's J joints.
        limits: Their bounds.
        device: None for a worn device that moves the hand's own joints.
        take_s: Time in the take of each row, shape (K,).

    Raises:
        Refused: The device's joints are not those of its chain.
    """
    if device is not None and device.chain == "dlr-hit-ii":
        return _on_robot(wish_rad, geometry, names, limits, device, take_s)
    asked = wish_rad[:, joint_index(names)]
    boxed = _bounded(asked, limits)
    inside, pulled = into_hulls(boxed, names, limits.hulls, take_s)
    bounded, led = keep_clearance(inside, names, geometry, limits, take_s)
    played = forward(geometry, whole_hand(bounded, names)).landmarks_m[:, _TIPS]
    apart_m = np.linalg.norm(forward(geometry, wish_rad).landmarks_m[:, _TIPS] - played, axis=2)
    return Placed(bounded, _budget(apart_m), (*clip_notes(names, asked, limits), *pulled, *led))


def whole_hand(driven_rad: Float64, driven_joints: tuple[str, ...]) -> Float64:
    """The 21 angles (N, 21) from the driven ones (N, J): DIP follows PIP, the rest stay straight."""
    joints = np.zeros((len(driven_rad), len(JOINTS)))
    joints[:, joint_index(driven_joints)] = driven_rad
    for finger in FINGERS:
        if f"{finger}_dip" not in driven_joints:
            pip = JOINTS.index(f"{finger}_pip")
            joints[:, pip + 1] = DIP_PER_PIP * joints[:, pip]
    return joints


def _on_robot(
    wish_rad: Float64,
    geometry: HandGeometry,
    names: tuple[str, ...],
    limits: Limits,
    device: Capabilities,
    take_s: Float64,
) -> Placed:
    if names != ROBOT_JOINTS:
        raise Refused(
            "robot joints", ", ".join(names[:3]) + " ...", "those of its chain", "update the device"
        )
    low = np.maximum(limits.q_min_rad, device.q_min_rad)
    high = np.minimum(limits.q_max_rad, device.q_max_rad)
    shown = retarget(geometry, wish_rad, low, high)
    notes = posture_notes(names, shown.asked_rad, low, high, take_s)
    bounded, pulled = into_hulls(shown.joints_rad, names, limits.hulls, take_s)
    return Placed(bounded, _budget(shown.residual_m), (*notes, *pulled))


def _bounded(asked_rad: Float64, limits: Limits) -> Float64:
    columns = [
        within(column, float(low), float(high))
        for column, low, high in zip(asked_rad.T, limits.q_min_rad, limits.q_max_rad, strict=True)
    ]
    return np.stack(columns, axis=1)


def _budget(apart_m: Float64) -> dict[str, float]:
    """Root mean square over time (K, 5), by digit."""
    rms = np.sqrt((apart_m**2).mean(axis=0))
    return {digit: float(value) for digit, value in zip(DIGITS, rms, strict=True)}
