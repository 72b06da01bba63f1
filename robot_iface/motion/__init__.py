"""Geometry and timing of a movement: path, player of one path coordinate, transfers, static check."""

from robot_iface.motion.check import Violation, check_path
from robot_iface.motion.path import QuinticPath, Setpoint
from robot_iface.motion.player import PathPlayer, PathState
from robot_iface.motion.transfer import plan_transfer, transfer_speeds

__all__ = [
    "PathPlayer",
    "PathState",
    "QuinticPath",
    "Setpoint",
    "Violation",
    "check_path",
    "plan_transfer",
    "transfer_speeds",
]
