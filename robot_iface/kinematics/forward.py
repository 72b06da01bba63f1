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
# Every landmark that a joint moves: the joint, the landmark, and the landmark at the joint itself.
_MOVES = np.array(
    [
        (joint, 4 * digit + point, 4 * digit + _BONE[slot])
        for joint, (digit, slot) in enumerate(zip(_DIGIT, _SLOT, strict=True))
        for point in range(_BONE[slot] + 1, 4)
    ]
)
_MOVER, _MOVED, _PIVOT = _MOVES.T


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
    landmarks, rotations = _right_frames(geometry, _slots(joints_rad))
    return HandFrames(landmarks * geometry.mirror, rotations * geometry.mirror[:, None])


def jacobian(geometry: HandGeometry, joints_rad: Float64) -> Float64:
    """Derivative of the landmarks with respect to the joint angles.

    Args:
        geometry: The hand.
        joints_rad: Joint angles in the order of JOINTS, shape (..., 21).

    Returns:
        d landmarks_m / d joints_rad, shape (..., 25, 3, 21), m/rad.
    """
    slots = _slots(joints_rad)
    points, rotations = _right_frames(geometry, slots)
    axes = _slot_axes(geometry, rotations, slots)[..., _DIGIT[_MOVER], _SLOT[_MOVER], :]
    arms = points[..., _MOVED, :] - points[..., _PIVOT, :]
    result = np.zeros((*joints_rad.shape[:-1], 25, 3, 21))
    for component, (one, two) in enumerate(((1, 2), (2, 0), (0, 1))):
        moment = axes[..., one] * arms[..., two] - axes[..., two] * arms[..., one]
        result[..., _MOVED, component, _MOVER] = moment * geometry.mirror[component]
    return result


def _right_frames(geometry: HandGeometry, slots: Float64) -> tuple[Float64, Float64]:
    """Landmarks, (..., 25, 3), and bone axes, (..., 5, 3, 3, 3), of the hand's right-hand form."""
    first = geometry.base_rotation @ _abduct_flex(slots[..., 1], slots[..., 0])
    second = first @ _abduct_flex(slots[..., 3], slots[..., 2])
    third = second @ _flex(slots[..., 4])
    rotations = np.stack([first, second, third], axis=-3)
    steps = rotations[..., :, 2] * geometry.bones_m[:, :, None]
    points = np.empty((*slots.shape[:-1], 4, 3))
    points[..., 0, :] = geometry.bases_m
    points[..., 1:, :] = geometry.bases_m[:, None, :] + np.cumsum(steps, axis=-2)
    lead = slots.shape[:-2]
    landmarks = np.empty((*lead, 25, 3))
    landmarks[..., :20, :] = points.reshape(*lead, 20, 3)
    landmarks[..., 20:, :] = geometry.palm_m
    return landmarks, rotations


def _slots(joints_rad: Float64) -> Float64:
    """The 21 angles spread over (5 digits, 5 slots); a finger has no second abduction."""
    slots = np.zeros((*joints_rad.shape[:-1], 5, 5))
    slots[..., _DIGIT, _SLOT] = joints_rad
    return slots


def _abduct_flex(abduction_rad: Float64, flexion_rad: Float64) -> Float64:
    """Rx(-abduction) Ry(flexion), shape (..., 3, 3)."""
    turn = _flex(flexion_rad)
    ca, sa = np.cos(abduction_rad), np.sin(abduction_rad)
    along = turn[..., 2, :].copy()
    turn[..., 1, :] = sa[..., None] * along
    turn[..., 2, :] = ca[..., None] * along
    turn[..., 1, 1], turn[..., 2, 1] = ca, -sa
    return turn


def _flex(flexion_rad: Float64) -> Float64:
    """Ry(flexion), shape (..., 3, 3)."""
    cos, sin = np.cos(flexion_rad), np.sin(flexion_rad)
    turn = np.zeros((*flexion_rad.shape, 3, 3))
    turn[..., 0, 0] = turn[..., 2, 2] = cos
    turn[..., 0, 2] = sin
    turn[..., 2, 0] = -sin
    turn[..., 1, 1] = 1.0
    return turn


def _slot_axes(geometry: HandGeometry, rotations: Float64, slots: Float64) -> Float64:
    """Unit axis of every slot's joint in the (right-hand) palm frame, shape (..., 5, 5, 3)."""
    axes = np.empty((*slots.shape, 3))
    axes[..., 0, :] = rotations[..., 0, :, 1]
    axes[..., 1, :] = -geometry.base_rotation[:, :, 0]
    axes[..., 2, :] = rotations[..., 1, :, 1]
    axes[..., 3, :] = -rotations[..., 0, :, 0]
    axes[..., 4, :] = rotations[..., 2, :, 1]
    return axes
