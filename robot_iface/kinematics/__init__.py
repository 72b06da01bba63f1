"""Hand geometry and its kinematics, for people and robots."""

from robot_iface.kinematics.anatomy import DIP_PER_PIP, JOINT_MAX_RAD, JOINT_MIN_RAD, couple_dip
from robot_iface.kinematics.forward import HandFrames, forward, jacobian
from robot_iface.kinematics.hand import HandGeometry, average_hand, patient_hand

__all__ = [
    "DIP_PER_PIP",
    "JOINT_MAX_RAD",
    "JOINT_MIN_RAD",
    "HandFrames",
    "HandGeometry",
    "average_hand",
    "couple_dip",
    "forward",
    "jacobian",
    "patient_hand",
]
