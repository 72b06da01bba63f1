"""The last layer before the motors: limits, watchdogs and the supervisor with its latched states."""

from robot_iface.safety.closing import brake_and_close
from robot_iface.safety.shipped import MOTOR_CAP_NM, shipped_limits
from robot_iface.safety.supervisor import Supervisor
from robot_iface.safety.watch import Outcome, Watch

__all__ = ["MOTOR_CAP_NM", "Outcome", "Supervisor", "Watch", "brake_and_close", "shipped_limits"]
