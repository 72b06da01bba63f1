"""What is known of a hand before it is seen: it rests, it has limits, and the tip follows the middle joint.

All of it is weak: a joint that the markers determine is moved by less than its own uncertainty.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robot_iface.kinematics import DIP_PER_PIP, JOINT_MAX_RAD, JOINT_MIN_RAD
from sessions.records.fields import Float64
from sessions.records.names import FINGERS, JOINTS

COUPLING_STD_RAD = 0.2
"""By how much a DIP joint strays from two thirds of its PIP joint."""
LIMIT_STD_RAD = 0.05
"""How softly the anatomical range ends."""

_FLEXION_STD_RAD = 0.9
_ABDUCTION_STD_RAD = 0.25
_THUMB_STD_RAD = 0.5
_OPEN_RAD = 0.25


@dataclass(frozen=True, slots=True)
class JointPrior:
    """Expected joint angles, such as a tracker's prediction.

    Attributes:
        joints_rad: Expected angles, shape (N, 21).
        std_rad: Their standard deviations, shape (N, 21) or (21,).
    """

    joints_rad: Float64
    std_rad: Float64


def rest_prior(frames: int) -> JointPrior:
    """The hand at rest, slightly closed, for a number of frames."""
    mean = np.array([_OPEN_RAD if "flexion" in joint or joint.endswith("pip") else 0.0 for joint in JOINTS])
    std = np.full(len(JOINTS), _FLEXION_STD_RAD)
    std[[joint.endswith("abduction") for joint in JOINTS]] = _ABDUCTION_STD_RAD
    std[[joint.startswith("thumb") and "mcp_abduction" not in joint for joint in JOINTS]] = _THUMB_STD_RAD
    std[JOINTS.index("thumb_mcp_abduction")] = 0.15
    for finger in FINGERS:
        mean[JOINTS.index(f"{finger}_dip")] = DIP_PER_PIP * _OPEN_RAD
    return JointPrior(np.tile(mean, (frames, 1)), std)


def coupling_precision() -> Float64:
    """Precision matrix of the four couplings DIP - 2/3 PIP about zero, shape (21, 21), rad^-2."""
    rows = np.zeros((len(FINGERS), len(JOINTS)))
    for row, finger in enumerate(FINGERS):
        rows[row, JOINTS.index(f"{finger}_dip")] = 1.0
        rows[row, JOINTS.index(f"{finger}_pip")] = -DIP_PER_PIP
    return rows.T @ rows / COUPLING_STD_RAD**2


def beyond_limits(joints_rad: Float64) -> Float64:
    """How far each angle lies outside the anatomical range, signed, same shape, rad."""
    return joints_rad - np.clip(joints_rad, JOINT_MIN_RAD, JOINT_MAX_RAD)


def oddity(joints_rad: Float64) -> float:
    """How strange a posture (21,) is, in squared standard deviations: not at rest, uncoupled, beyond limits.

    Args:
        joints_rad: Joint angles.
    """
    out = beyond_limits(joints_rad) / LIMIT_STD_RAD
    away = (joints_rad - _REST.joints_rad[0]) / _REST.std_rad
    return float(out @ out + away @ away + joints_rad @ _COUPLING @ joints_rad)


def starting_postures() -> Float64:
    """Open, half closed, and a fist with the thumb across: where a fit from nothing begins, (3, 21), rad."""
    postures = np.zeros((3, len(JOINTS)))
    for row, (mcp, pip) in enumerate(((0.1, 0.15), (0.6, 0.8), (1.2, 1.5))):
        for finger in FINGERS:
            start = JOINTS.index(f"{finger}_mcp_flexion")
            postures[row, start : start + 4] = (mcp, 0.0, pip, DIP_PER_PIP * pip)
        postures[row, JOINTS.index("thumb_mcp_flexion")] = postures[row, JOINTS.index("thumb_ip")] = (
            0.2 + 0.3 * row
        )
    return postures


_REST = rest_prior(1)
_COUPLING = coupling_precision()
