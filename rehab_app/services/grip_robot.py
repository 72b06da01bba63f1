"""A target grip on the DLR-HIT-Hand II, which nobody wears: where its own fingertips should go.

Its own chain, its own fingertips: every digit shows what the person's digit does, as far as its joints reach
(``hand.retarget``), so a grip that is played to the robot ends where this says.
"""

from __future__ import annotations

import numpy as np

from rehab_app.hand.retarget import ROBOT_JOINTS, retarget
from robot_iface.kinematics import HandGeometry
from robot_iface.kinematics.dlr_hit import FINGER_MAX_RAD, FINGER_MIN_RAD, dlr_hit_hand, hand_points
from robot_iface.types import joint_index
from sessions.records import DIGITS
from sessions.records.fields import Float64

_HAND = dlr_hit_hand()
_OWN = joint_index(ROBOT_JOINTS)
_LOW_RAD, _HIGH_RAD = (np.tile(end, len(DIGITS)) for end in (FINGER_MIN_RAD, FINGER_MAX_RAD))


def robot_fingertips_m(joints_rad: Float64) -> Float64:
    """Fingertips of the robot in its palm frame, shape (5, 3).

    Args:
        joints_rad: Its posture as a whole hand in the order of JOINTS, shape (21,).
    """
    return hand_points(_HAND, joints_rad[_OWN].reshape(len(DIGITS), 3))[:, 3]


def robot_goal_m(geometry: HandGeometry, joints_rad: Float64) -> Float64:
    """The same where the robot shows a person's posture, as far as its joints reach, shape (5, 3).

    Args:
        geometry: The person's hand.
        joints_rad: The posture, shape (21,).
    """
    shown = retarget(geometry, joints_rad[None], _LOW_RAD, _HIGH_RAD).joints_rad[0]
    return hand_points(_HAND, shown.reshape(len(DIGITS), 3))[:, 3]
