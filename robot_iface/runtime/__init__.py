"""One control cycle, the exercise that it plays, and the record of both."""

from robot_iface.runtime.cycle import Cycle, perform, run
from robot_iface.runtime.exercise import Exercise
from robot_iface.runtime.live import PHASES, STARTERS, LiveSample, Monitor, Unwatched
from robot_iface.runtime.orders import (
    Advance,
    Inbox,
    Order,
    Pain,
    Patient,
    Pause,
    PresentPatient,
    Reset,
    Resume,
    Reverse,
    ScriptedInbox,
    SetSpeed,
)
from robot_iface.runtime.record import Message, Recorder, Sink
from robot_iface.runtime.rig import LoopClock, Rig, Surroundings
from robot_iface.runtime.seal import canonical_bytes, check_certificate, plan_parts, seal

__all__ = [
    "PHASES",
    "STARTERS",
    "Advance",
    "Cycle",
    "Exercise",
    "Inbox",
    "LiveSample",
    "LoopClock",
    "Message",
    "Monitor",
    "Order",
    "Pain",
    "Patient",
    "Pause",
    "PresentPatient",
    "Recorder",
    "Reset",
    "Resume",
    "Reverse",
    "Rig",
    "ScriptedInbox",
    "SetSpeed",
    "Sink",
    "Surroundings",
    "Unwatched",
    "canonical_bytes",
    "check_certificate",
    "perform",
    "plan_parts",
    "run",
    "seal",
]
