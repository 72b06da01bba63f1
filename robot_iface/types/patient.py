"""The patient as the motion core knows one: who is simulated, and on whom a plan is rehearsed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from robot_iface.types.hand import Side

VirtualKind = Literal[
    "healthy",
    "flaccid",
    "weak",
    "mas1+",
    "mas2",
    "mas3",
    "contracture",
    "tremor",
    "clonus",
    "slacking",
    "resisting",
    "tiring",
]
VIRTUAL_KINDS: tuple[VirtualKind, ...] = (
    "healthy",
    "flaccid",
    "weak",
    "mas1+",
    "mas2",
    "mas3",
    "contracture",
    "tremor",
    "clonus",
    "slacking",
    "resisting",
    "tiring",
)


@dataclass(frozen=True, slots=True)
class Spasm:
    """A flexor spasm of the virtual patient.

    Attributes:
        start_s: Since the device was opened.
        duration_s: How long it lasts.
        size_nm: Torque on each joint concerned, flexion positive.
        joint: Driven joint, empty for all flexion joints.
        clonus_hz: It comes and goes at this frequency; 0 for a steady one.
    """

    start_s: float
    duration_s: float
    size_nm: float
    joint: str = ""
    clonus_hz: float = 0.0


@dataclass(frozen=True, slots=True)
class PatientTwin:
    """The virtual patient in a simulated device; also the twin on which a path is rehearsed.

    Attributes:
        kind: Impairment, one of VIRTUAL_KINDS.
        side: Side of the hand.
        hand_length_m: Wrist crease to middle fingertip.
        bones_m: Measured bones, five digits of three; empty for average proportions of that length.
        stiffness_nm_rad: Measured or recorded passive MCP stiffness; 0 for the kind's own.
        spasms: Spasms at their times.
        axis_offset_m: How far the device's axes lie from the joints' (distal, dorsal).
        strap_slip_rad: By how much every strap has slipped.
        slip_at_s: When it slips, since the device was opened.
    """

    kind: VirtualKind = "healthy"
    side: Side = "right"
    hand_length_m: float = 0.189
    bones_m: tuple[tuple[float, ...], ...] = ()
    stiffness_nm_rad: float = 0.0
    spasms: tuple[Spasm, ...] = ()
    axis_offset_m: tuple[float, float] = (0.0, 0.0)
    strap_slip_rad: float = 0.0
    slip_at_s: float = 0.0
