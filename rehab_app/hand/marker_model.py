"""Where a person's markers are for given joint angles, and how they move with each joint."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from rehab_app.hand.protocol import MarkerProtocol
from rehab_app.hand.subject import Subject
from robot_iface.kinematics import HandFrames, HandGeometry, forward
from sessions.errors import Refused
from sessions.records.fields import Float64, Int64
from sessions.records.names import JOINTS

# Of each of the 21 joints: its digit, the bone that it is the first to move, and whether it abducts.
_JOINT_DIGIT = np.array([0] * 5 + [finger for finger in (1, 2, 3, 4) for _ in range(4)])
_JOINT_BONE = np.array([0, 0, 1, 1, 2] + [0, 0, 1, 2] * 4)
_ABDUCTS = np.array([joint.endswith("abduction") for joint in JOINTS])
_LEFT = np.array([1.0, -1.0, 1.0])
_TIPS = np.array([3, 7, 11, 15, 19])
_MOVED_TIPS: tuple[Int64, Int64] = (_JOINT_DIGIT, np.arange(21))


@dataclass(frozen=True, slots=True)
class PlacedMarkers:
    """Markers and what they ride on for given angles, in the *right-hand form* of the palm frame.

    Attributes:
        frames: Landmarks and bone axes.
        segments: Rotation of each of SEGMENTS, shape (..., 16, 3, 3).
        p_m: Marker positions, shape (..., M, 3).
    """

    frames: HandFrames
    segments: Float64
    p_m: Float64


class MarkerModel:
    """A subject wearing a protocol's markers.

    Args:
        subject: The person.
        protocol: The markers.

    Raises:
        Refused: The subject wears other markers than the protocol's.
    """

    def __init__(self, subject: Subject, protocol: MarkerProtocol) -> None:
        if subject.marker_names != protocol.names:
            raise Refused(
                "subject",
                "wearing other markers",
                f"one of protocol {protocol.name}",
                "calibrate this protocol",
            )
        self.subject = subject
        self.protocol = protocol
        self.geometry: HandGeometry = subject.geometry
        self.right: HandGeometry = replace(subject.geometry, side="right")
        self.anchors: Int64 = protocol.anchors
        self.segments: Int64 = protocol.segments
        self.digit: Int64 = np.where(self.segments < 15, self.segments // 3, -1)
        bone = np.where(self.segments < 15, self.segments % 3, -1)
        moved = (self.digit[:, None] == _JOINT_DIGIT) & (bone[:, None] >= _JOINT_BONE)
        self._moved: tuple[Int64, Int64] = (np.nonzero(moved)[0], np.nonzero(moved)[1])
        self._mirror: Float64 = _LEFT if subject.geometry.side == "left" else np.ones(3)

    @property
    def mirror(self) -> Float64:
        """Factors from the right-hand form to this side's palm frame, shape (3,)."""
        return self._mirror

    def positions(self, joints_rad: Float64) -> Float64:
        """Markers in the palm frame (..., M, 3), m, for joint angles (..., 21)."""
        return self.place(joints_rad).p_m * self.mirror

    def normals(self, joints_rad: Float64) -> Float64:
        """Unit vectors out of the back of each marker's segment in the palm frame, shape (..., M, 3)."""
        return -self.place(joints_rad).segments[..., 0][..., self.segments, :] * self.mirror

    def jacobian(self, joints_rad: Float64) -> Float64:
        """Derivative of the markers in the palm frame with respect to the joints, (..., M, 3, 21), m/rad."""
        return self.right_jacobian(self.place(joints_rad)) * self.mirror[:, None]

    def place(self, joints_rad: Float64) -> PlacedMarkers:
        """Markers and bones for joint angles (..., 21), in the right-hand form."""
        frames = forward(self.right, joints_rad)
        lead = joints_rad.shape[:-1]
        palm = np.broadcast_to(np.eye(3), (*lead, 1, 3, 3))
        segments = np.concatenate([frames.rotations.reshape(*lead, 15, 3, 3), palm], axis=-3)
        offsets = segments[..., self.segments, :, :] @ self.subject.marker_offset_m[:, :, None]
        return PlacedMarkers(frames, segments, frames.landmarks_m[..., self.anchors, :] + offsets[..., 0])

    def right_jacobian(self, placed: PlacedMarkers) -> Float64:
        """Derivative of ``placed.p_m`` with respect to the joints, (..., M, 3, 21), m/rad."""
        return self._slopes(placed.frames, placed.p_m, self._moved)

    def fingertips(self, placed: PlacedMarkers) -> tuple[Float64, Float64]:
        """Fingertips in the palm frame (..., 5, 3), m, and their derivative in the joints (..., 5, 3, 21)."""
        tips = placed.frames.landmarks_m[..., _TIPS, :]
        slopes = self._slopes(placed.frames, tips, _MOVED_TIPS)
        return tips * self._mirror, slopes * self._mirror[:, None]

    def _slopes(self, frames: HandFrames, p_m: Float64, moved: tuple[Int64, Int64]) -> Float64:
        """Derivative of points (..., K, 3) in the joints that move them, (..., K, 3, 21)."""
        point, joint = moved
        axes = _joint_axes(self.right, frames)
        pivots = frames.landmarks_m[..., 4 * _JOINT_DIGIT + _JOINT_BONE, :]
        arms = p_m[..., point, :] - pivots[..., joint, :]
        result = np.zeros((*p_m.shape[:-1], 21, 3))
        result[..., point, joint, :] = cross(axes[..., joint, :], arms)
        return np.swapaxes(result, -1, -2)


def cross(a: Float64, b: Float64) -> Float64:
    """Vector product over the last axis; several times faster than numpy's for short vectors."""
    x = a[..., 1] * b[..., 2] - a[..., 2] * b[..., 1]
    y = a[..., 2] * b[..., 0] - a[..., 0] * b[..., 2]
    z = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    return np.stack([x, y, z], axis=-1)


def _joint_axes(geometry: HandGeometry, frames: HandFrames) -> Float64:
    """Unit axis of each of the 21 joints in the right-hand palm frame, shape (..., 21, 3).

    Flexion turns about the radial axis of the bone that it moves. Abduction turns about minus the palmar axis
    of what the bone hangs on: the digit's base, or the bone before.
    """
    flexion = frames.rotations[..., 1][..., _JOINT_DIGIT, _JOINT_BONE, :]
    before = frames.rotations[..., 0][..., _JOINT_DIGIT, np.maximum(_JOINT_BONE - 1, 0), :]
    base = geometry.base_rotation[_JOINT_DIGIT, :, 0]
    abduction = -np.where((_JOINT_BONE > 0)[:, None], before, base)
    return np.where(_ABDUCTS[:, None], abduction, flexion)
