"""Another person's hand: no one has average proportions."""

from __future__ import annotations

import numpy as np

from rehab_app.geometry.rotation import turn
from robot_iface.kinematics import HandGeometry, average_hand
from sessions.records import Side

_BONE_SHARE = 0.05
_BASE_LOW_M = np.array(
    [-0.0005, -0.002, -0.002]
)  # palmar, radial, distal: knuckles arch towards the palm only,
_BASE_HIGH_M = np.array([0.003, 0.002, 0.002])  # so that markers on the back stay on the skin
_PALM_M = np.array([0.0, 0.002, 0.002])
_THUMB_TURN_RAD = float(np.deg2rad(7.0))
_FINGER_TURN_RAD = float(np.deg2rad(2.5))


def varied_hand(length_m: float, side: Side, rng: np.random.Generator) -> HandGeometry:
    """A hand of about this length whose bones, joints and axes lie where chance puts them.

    Args:
        length_m: Hand length of the average hand that is varied.
        side: Side of the hand.
        rng: Draws by how much every bone is longer, every first joint displaced, every digit turned.
    """
    mean = average_hand(length_m, side)
    bones = mean.bones_m * (1.0 + _BONE_SHARE * rng.uniform(-1.0, 1.0, (5, 3)))
    bases = mean.bases_m + rng.uniform(_BASE_LOW_M, _BASE_HIGH_M, (5, 3))
    palm = mean.palm_m + _PALM_M * rng.uniform(-1.0, 1.0, (5, 3))
    most = np.array([_THUMB_TURN_RAD] + [_FINGER_TURN_RAD] * 4)[:, None]
    rotation = mean.base_rotation @ turn(most * rng.uniform(-1.0, 1.0, (5, 3)))
    return HandGeometry(side, bases, rotation, bones, palm)
