"""The last layer before the motors: limits, watchdogs and the supervisor with its latched states."""

from robot_iface.safety.admission import admit_limits
from robot_iface.safety.closing import brake_and_close
from robot_iface.safety.hulls import PackedHulls, pack_hulls
from robot_iface.safety.shipped import (
    MOTOR_CAP_NM,
    THERAPIST_CAP_NM,
    raised_limits,
    shipped_limits,
)
from robot_iface.safety.supervisor import Supervisor
from robot_iface.safety.watch import Outcome, Watch

__all__ = [
    "MOTOR_CAP_NM",
    "THERAPIST_CAP_NM",
    "Outcome",
    "PackedHulls",
    "Supervisor",
    "Watch",
    "admit_limits",
    "brake_and_close",
    "pack_hulls",
    "raised_limits",
    "shipped_limits",
]
