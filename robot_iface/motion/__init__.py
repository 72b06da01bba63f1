"""Geometry and timing of a movement: path, player of one path coordinate, transfers, static check."""

from robot_iface.motion.check import Violation, check_path
from robot_iface.motion.narrowing import Narrowing, narrowed, unchanged
from robot_iface.motion.path import QuinticPath, Setpoint
from robot_iface.motion.player import AT_START, PathPlayer, PathState
from robot_iface.motion.transfer import Transfer, transfer_speeds

__all__ = [
    "AT_START",
    "Narrowing",
    "PathPlayer",
    "PathState",
    "QuinticPath",
    "Setpoint",
    "Transfer",
    "Violation",
    "check_path",
    "narrowed",
    "transfer_speeds",
    "unchanged",
]
