"""Forward kinematics of a hand and its Jacobian, for one pose or many at once.

Every digit is the same chain: flexion and abduction at the first joint, flexion and (thumb only) abduction
at the second, flexion at the third. Flexion turns about the digit's radial axis +y and carries the tip to
palmar; positive abduction turns about -x and carries it to radial (the thumb's side).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robot_iface.kinematics.hand import HandGeometry
from robot_iface.types import Float64

# For each of the 21 joints: its digit, and its slot in (flexion 1, abduction 1, flexion 2, abduction 2,
# flexion 3).
_DIGIT = np.array([0] * 5 + [finger for finger in (1, 2, 3, 4) for _ in range(4)])
_SLOT = np.array([0, 1, 2, 3, 4] + [0, 1, 2, 4] * 4)
_BONE = np.array([0, 0, 1, 1, 2])  # the bone that each slot is the first to move


@dataclass(frozen=True, slots=True)
class HandFrames:
    """Where everything of the hand is, in the palm frame. Leading dimensions are those of the angles.

    Attributes:
        landmarks_m: The 25 landmarks in the order of LANDMARKS, shape (..., 25, 3).
        rotations: Axes (palmar, radial, distal) of each bone as columns, shape (..., 5, 3, 3, 3). On a left
            hand the axes are mirror images, so that the first column still points out of the palm.
    """

    landmarks_m: Float64
    rotations: Float64


def forward(geometry: HandGeometry, joints_rad: Float64) -> HandFrames:
    """Landmarks and bone axes of a hand.

    Args:
        geometry: The hand.
        joints_rad: Joint angles in the order of JOINTS, shape (..., 21).
    """
    angles = _slots(joints_rad)
    first = geometry.base_rotation @ _abduct_flex(angles[..., 1], angles[..., 0])
    second = first @ _abduct_flex(angles[..., 3], angles[..., 2])
    third = second @ _abduct_flex(np.zeros_like(angles[..., 4]), angles[..., 4])
    rotations = np.stack([first, second, third], axis=-3)
    steps = rotations[..., :, 2] * geometry.bones_m[:, :, None]
    points = np.empty((*angles.shape[:-1], 4, 3))
    points[..., 0, :] = geometry.bases_m
    points[..., 1:, :] = geometry.bases_m[:, None, :] + np.cumsum(steps, axis=-2)
    lead = joints_rad.shape[:-1]
    landmarks = np.empty((*lead, 25, 3))
    landmarks[..., :20, :] = points.reshape(*lead, 20, 3)
    landmarks[..., 20:, :] = geometry.palm_m
    return HandFrames(landmarks * geometry.mirror, rotations * geometry.mirror[:, None])


def jacobian(geometry: HandGeometry, joints_rad: Float64) -> Float64:
    """Derivative of the landmarks with respect to the joint angles.

    Args:
        geometry: The hand.
        joints_rad: Joint angles in the order of JOINTS, shape (..., 21).

    Returns:
        d landmarks_m / d joints_rad, shape (..., 25, 3, 21), m/rad.
    """
    right = HandGeometry("right", geometry.bases_m, geometry.base_rotation, geometry.bones_m, geometry.palm_m)
    frames = forward(right, joints_rad)
    lead = joints_rad.shape[:-1]
    points = frames.landmarks_m[..., :20, :].reshape(*lead, 5, 4, 3)
    axes = _slot_axes(geometry, frames.rotations, _slots(joints_rad))
    result = np.zeros((*lead, 25, 3, 21))
    for joint in range(21):
        digit, slot = _DIGIT[joint], _SLOT[joint]
        bone = _BONE[slot]
        arms = points[..., digit, bone + 1 :, :] - points[..., digit, bone : bone + 1, :]
        moved = slice(4 * digit + bone + 1, 4 * digit + 4)
        result[..., moved, :, joint] = np.cross(axes[..., digit, None, slot, :], arms)
    return result * geometry.mirror[:, None]


def _slots(joints_rad: Float64) -> Float64:
    """The 21 angles spread over (5 digits, 5 slots); a finger has no second abduction."""
    slots = np.zeros((*joints_rad.shape[:-1], 5, 5))
    slots[..., _DIGIT, _SLOT] = joints_rad
    return slots


def _abduct_flex(abduction_rad: Float64, flexion_rad: Float64) -> Float64:
    """Rx(-abduction) Ry(flexion), shape (..., 3, 3)."""
    ca, sa = np.cos(abduction_rad), np.sin(abduction_rad)
    cf, sf = np.cos(flexion_rad), np.sin(flexion_rad)
    zero = np.zeros_like(ca)
    rows = [cf, zero, sf, -sa * sf, ca, sa * cf, -ca * sf, -sa, ca * cf]
    return np.stack(rows, axis=-1).reshape(*ca.shape, 3, 3)


def _slot_axes(geometry: HandGeometry, rotations: Float64, slots: Float64) -> Float64:
    """Unit axis of every slot's joint in the (right-hand) palm frame, shape (..., 5, 5, 3)."""
    axes = np.empty((*slots.shape, 3))
    axes[..., 0, :] = rotations[..., 0, :, 1]
    axes[..., 1, :] = -geometry.base_rotation[:, :, 0]
    axes[..., 2, :] = rotations[..., 1, :, 1]
    axes[..., 3, :] = -rotations[..., 0, :, 0]
    axes[..., 4, :] = rotations[..., 2, :, 1]
    return axes
