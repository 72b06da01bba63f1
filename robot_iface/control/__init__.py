"""Control laws and what they learn between repetitions."""

from robot_iface.control.assist import AssistAsNeeded
from robot_iface.control.chain import Chain, dlr_hit_chain, hand_chain
from robot_iface.control.choice import make_law
from robot_iface.control.feedforward import FeedForward
from robot_iface.control.fingertip import FingertipLaw
from robot_iface.control.gains import Gains, learning_share, nominal_gains, thesis_gains
from robot_iface.control.goal import Goal, Law
from robot_iface.control.impedance import ImpedanceLaw
from robot_iface.control.modes import BUILT_MODES, require_mode
from robot_iface.control.stability import check_gains
from robot_iface.control.trigger import Start, StartTrigger

__all__ = [
    "BUILT_MODES",
    "AssistAsNeeded",
    "Chain",
    "FeedForward",
    "FingertipLaw",
    "Gains",
    "Goal",
    "ImpedanceLaw",
    "Law",
    "Start",
    "StartTrigger",
    "check_gains",
    "dlr_hit_chain",
    "hand_chain",
    "learning_share",
    "make_law",
    "nominal_gains",
    "require_mode",
    "thesis_gains",
]
