"""Values that the motion core is handed, passes on and reports."""

from robot_iface.types.device import (
    THESIS_INERTIA_KG_M2,
    Capabilities,
    CommandMode,
    DeviceCommand,
    DeviceState,
)
from robot_iface.types.hand import (
    DIGITS,
    FINGERS,
    JOINTS,
    LANDMARKS,
    Float64,
    Int64,
    Side,
    UInt8,
    joint_index,
)
from robot_iface.types.limits import Hull, Limits
from robot_iface.types.patient import VIRTUAL_KINDS, PatientTwin, Spasm, VirtualKind
from robot_iface.types.plan import (
    MODES,
    SPACES,
    Certificate,
    Mode,
    Plan,
    Prescription,
    ReferencePath,
    Space,
    Sweep,
)
from robot_iface.types.run import PhaseChange, RunEnd, SafetyEvent, SafetyState, TickBlock

__all__ = [
    "DIGITS",
    "FINGERS",
    "JOINTS",
    "LANDMARKS",
    "MODES",
    "SPACES",
    "THESIS_INERTIA_KG_M2",
    "VIRTUAL_KINDS",
    "Capabilities",
    "Certificate",
    "CommandMode",
    "DeviceCommand",
    "DeviceState",
    "Float64",
    "Hull",
    "Int64",
    "Limits",
    "Mode",
    "PatientTwin",
    "PhaseChange",
    "Plan",
    "Prescription",
    "ReferencePath",
    "RunEnd",
    "SafetyEvent",
    "SafetyState",
    "Side",
    "Space",
    "Spasm",
    "Sweep",
    "TickBlock",
    "UInt8",
    "VirtualKind",
    "joint_index",
]
