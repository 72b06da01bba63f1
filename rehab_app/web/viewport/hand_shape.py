"""Flesh on the bones: where every ball and segment of a drawn hand lies for given joint angles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from rehab_app.web.viewport.solids import Solid, loft
from robot_iface.kinematics import HandFrames, HandGeometry, forward
from robot_iface.types import Float64

# Half thickness of a digit at its three joints (m, for a hand 0.189 m long); each segment tapers by 13 %.
_RADII_M = np.array(
    [
        [0.0165, 0.0118, 0.0102],
        [0.0102, 0.0089, 0.0079],
        [0.0104, 0.0091, 0.0080],
        [0.0098, 0.0086, 0.0076],
        [0.0086, 0.0075, 0.0067],
    ]
)
# Cross sections of forearm, wrist and palm (m, same hand): z, centre x, centre y, half thickness, half width.
_PALM_STATIONS_M = np.array(
    [
        [-0.075, -0.002, 0.000, 0.0195, 0.0270],
        [-0.030, -0.001, 0.000, 0.0175, 0.0245],
        [0.000, 0.000, 0.001, 0.0165, 0.0250],
        [0.018, 0.001, 0.001, 0.0170, 0.0310],
        [0.045, 0.001, -0.001, 0.0155, 0.0375],
        [0.068, 0.000, -0.002, 0.0130, 0.0400],
        [0.082, 0.000, -0.002, 0.0105, 0.0385],
        [0.0875, 0.000, 0.000, 0.0075, 0.0340],
        [0.0895, 0.000, 0.002, 0.0020, 0.0260],
    ]
)
_TIP_SHARE = 0.87
_REFERENCE_LENGTH_M = 0.189


@dataclass(frozen=True, slots=True)
class Bodies:
    """Placement of instanced solids in the palm frame.

    Attributes:
        p_palm_m: Positions, shape (N, 3).
        q_palm_wxyz: Rotations, shape (N, 4).
    """

    p_palm_m: Float64
    q_palm_wxyz: Float64


class HandShape:
    """The drawn form of one hand: 15 segments, 20 joint balls and 5 nails that move, a palm that does not.

    Args:
        geometry: The hand's bones.
    """

    def __init__(self, geometry: HandGeometry) -> None:
        self.geometry = geometry
        self._scale = geometry.length_m / _REFERENCE_LENGTH_M
        self._radii_m = _RADII_M * self._scale
        tip_radii = self._radii_m[:, 2] * _TIP_SHARE
        lengths = geometry.bones_m.copy()
        lengths[:, 2] -= 0.75 * tip_radii
        self._lengths_m = lengths
        wide = self._radii_m.reshape(15, 1)
        self.segment_scales_m: Float64 = np.concatenate([0.93 * wide, wide, lengths.reshape(15, 1)], axis=1)
        balls = np.concatenate([self._radii_m, tip_radii[:, None]], axis=1).reshape(20, 1)
        balls_m = np.concatenate([0.95 * balls, balls, balls], axis=1)
        nails_m = tip_radii[:, None] * np.array([0.22, 0.62, 0.80])
        self.ball_scales_m: Float64 = np.concatenate([balls_m, nails_m])
        self._tip_radii_m = tip_radii

    def pose(self, joints_rad: Float64) -> tuple[Bodies, Bodies]:
        """Segments (15) and balls with nails (25) at joint angles (21,)."""
        frames = forward(self.geometry, joints_rad)
        axes = _proper(frames)
        points = frames.landmarks_m[:20].reshape(5, 4, 3)
        bone_wxyz = _wxyz(axes.reshape(15, 3, 3)).reshape(5, 3, 4)
        segments = Bodies(points[:, :3].reshape(15, 3), bone_wxyz.reshape(15, 4))
        centres = points.copy()
        centres[:, 3] = points[:, 2] + axes[:, 2, :, 2] * self._lengths_m[:, 2, None]
        dorsal = -frames.rotations[:, 2, :, 0]
        nails = centres[:, 3] + dorsal * (0.80 * self._tip_radii_m[:, None])
        ball_wxyz = np.concatenate([bone_wxyz, bone_wxyz[:, 2:]], axis=1).reshape(20, 4)
        return segments, Bodies(
            np.concatenate([centres.reshape(20, 3), nails]), np.concatenate([ball_wxyz, bone_wxyz[:, 2]])
        )

    def palm(self) -> Solid:
        """Palm, wrist and a stub of forearm, so that nobody mistakes which end the fingers are on."""
        return _mirrored(loft(_PALM_STATIONS_M * self._scale), self.geometry.mirror)


def _proper(frames: HandFrames) -> Float64:
    """Bone axes as proper rotations: a left hand's are mirror images, and its solids are symmetric."""
    axes = frames.rotations.copy()
    if np.linalg.det(axes[0, 0]) < 0:
        axes[..., 1] *= -1.0
    return axes


def _wxyz(rotations: Float64) -> Float64:
    return np.asarray(Rotation.from_matrix(rotations).as_quat(scalar_first=True), dtype=np.float64)


def _mirrored(solid: Solid, mirror: Float64) -> Solid:
    faces = solid.faces if float(mirror.prod()) > 0 else solid.faces[:, ::-1]
    return Solid(solid.vertices_m * mirror, faces)
