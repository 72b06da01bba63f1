"""Control laws and what they learn between repetitions."""

from robot_iface.control.assist import AssistAsNeeded
from robot_iface.control.feedforward import FeedForward
from robot_iface.control.gains import Gains, thesis_gains
from robot_iface.control.goal import Goal, Law
from robot_iface.control.impedance import ImpedanceLaw
from robot_iface.control.modes import BUILT_MODES, require_mode
from robot_iface.control.trigger import Start, StartTrigger

__all__ = [
    "BUILT_MODES",
    "AssistAsNeeded",
    "FeedForward",
    "Gains",
    "Goal",
    "ImpedanceLaw",
    "Law",
    "Start",
    "StartTrigger",
    "require_mode",
    "thesis_gains",
]
