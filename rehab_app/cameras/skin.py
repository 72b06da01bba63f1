"""The skin of a hand as capsules, posed in the camera frame."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robot_iface.kinematics import HandFrames, HandGeometry
from sessions.records.fields import Float64

FINGER_RADIUS_M = 0.0073
"""Half the thickness of a finger: a little less than the height of a marker over the bone."""
_FOREARM_RADIUS_M = 0.021
_FOREARM = np.array(  # begin and end of two capsules behind the wrist, palm frame of a right hand
    [
        [[0.0200, 0.010, -0.012], [0.026, 0.010, -0.200]],
        [[0.0200, -0.010, -0.012], [0.026, -0.010, -0.200]],
    ]
)


@dataclass(frozen=True, slots=True)
class Capsules:
    """Cylinders with round ends.

    Attributes:
        begin_m: First end of each axis, shape (C, 3).
        end_m: Second end of each axis, shape (C, 3).
        radius_m: Radius of each, shape (C,).
    """

    begin_m: Float64
    end_m: Float64
    radius_m: Float64


def hand_skin(geometry: HandGeometry, frames: HandFrames) -> Capsules:
    """Skin of one posture in the palm frame.

    Args:
        geometry: The hand.
        frames: Its landmarks and bones for one posture (no leading dimension).
    """
    chains = frames.landmarks_m[:20].reshape(5, 4, 3)
    phalanges = np.stack([chains[:, :-1].reshape(-1, 3), chains[:, 1:].reshape(-1, 3)], axis=1)
    forearm = _FOREARM * geometry.mirror
    axes = np.concatenate([phalanges, _palm(chains, frames.landmarks_m[20]), forearm])
    radius = np.full(len(axes), FINGER_RADIUS_M)
    radius[-len(forearm) :] = _FOREARM_RADIUS_M
    return Capsules(axes[:, 0], axes[:, 1], radius)


def _palm(chains: Float64, wrist: Float64) -> Float64:
    """Axes that fill the palm: metacarpals and webs between them, shape (P, 2, 3)."""
    thumb, fingers = chains[0], chains[1:, 0]
    roots = wrist + 0.35 * (fingers - fingers.mean(axis=0)) * np.array([1.0, 1.0, 0.0])
    between = 0.5 * (fingers[:-1] + fingers[1:])
    lines = [*zip(roots, fingers, strict=True), *zip(0.5 * (roots[:-1] + roots[1:]), between, strict=True)]
    lines += [(wrist, thumb[0]), (thumb[0], fingers[0]), (0.6 * thumb[1] + 0.4 * thumb[0], fingers[0])]
    lines += [(fingers[0], fingers[1]), (fingers[1], fingers[2]), (fingers[2], fingers[3])]
    return np.array(lines)
