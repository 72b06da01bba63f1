"""Virtual patients: one row of parameters each."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from robot_iface.errors import Refused
from robot_iface.types import FINGERS, JOINTS, Float64

Will = Literal["none", "follow", "slack", "resist"]


@dataclass(frozen=True, slots=True)
class VirtualPatient:
    """What one virtual patient's hand does.

    Attributes:
        stiffness_nm_rad: Passive stiffness of an MCP joint (Front Bioeng Biotech 2020, 592637, Table 2); PIP
            alike, DIP 0.6 of it.
        damping_nms_rad: Passive damping of a joint.
        ability: Voluntary effort, 0 none to 1 sound: scales a servo to an equilibrium posture.
        will: What the patient does when cued: nothing, follow the movement, follow it less each time (slack),
            or hold the resting posture, cued or not (resist).
        spasticity_nms_rad: Reflex torque into flexion per speed of extension beyond 30 deg/s, 30 ms late
            (shape after Kamper & Rymer 2000; size assumed).
        tremor_nm: Amplitude of a 5 Hz tremor torque at the MCP joints.
        flexed: Rests with the fingers drawn in, as a spastic hand does.
    """

    stiffness_nm_rad: float
    damping_nms_rad: float = 0.002
    ability: float = 0.0
    will: Will = "none"
    spasticity_nms_rad: float = 0.0
    tremor_nm: float = 0.0
    flexed: bool = False

    def rest_rad(self) -> Float64:
        """The hand at rest, in the order of JOINTS, shape (21,)."""
        angles = _FLEXED_DEG if self.flexed else _RELAXED_DEG
        return np.deg2rad([angles.get(joint.removeprefix(_finger(joint)), 0.0) for joint in JOINTS])


_THUMB_DEG = {
    "thumb_cmc_flexion": 8.0,
    "thumb_cmc_abduction": 12.0,
    "thumb_mcp_flexion": 12.0,
    "thumb_ip": 15.0,
}
_RELAXED_DEG = {**_THUMB_DEG, "_mcp_flexion": 25.0, "_pip": 33.0, "_dip": 22.0}
_FLEXED_DEG = {**_THUMB_DEG, "_mcp_flexion": 42.0, "_pip": 48.0, "_dip": 32.0}

_KINDS: dict[str, VirtualPatient] = {
    "healthy": VirtualPatient(0.040, ability=0.9, will="follow"),
    "flaccid": VirtualPatient(0.015, damping_nms_rad=0.001),
    "weak": VirtualPatient(0.040, ability=0.25, will="follow"),
    "mas1+": VirtualPatient(0.090, ability=0.3, will="follow", spasticity_nms_rad=0.03, flexed=True),
    "mas2": VirtualPatient(0.520, ability=0.3, will="follow", spasticity_nms_rad=0.06, flexed=True),
    "mas3": VirtualPatient(0.640, ability=0.15, will="follow", spasticity_nms_rad=0.10, flexed=True),
    "contracture": VirtualPatient(0.30, ability=0.6, will="follow", flexed=True),
    "clonus": VirtualPatient(0.090, ability=0.3, will="follow", spasticity_nms_rad=0.06, flexed=True),
    "tiring": VirtualPatient(0.040, ability=0.7, will="slack"),
    "tremor": VirtualPatient(0.040, ability=0.7, will="follow", tremor_nm=0.03),
    "slacking": VirtualPatient(0.040, ability=0.6, will="slack"),
    "resisting": VirtualPatient(0.040, ability=0.2, will="resist"),
}


def virtual_patient(kind: str) -> VirtualPatient:
    """The parameters of a kind of virtual patient.

    Raises:
        Refused: There is no such kind.
    """
    if kind not in _KINDS:
        raise Refused("virtual patient", repr(kind), "one of " + ", ".join(_KINDS), "choose one of these")
    return _KINDS[kind]


def _finger(joint: str) -> str:
    """The finger that a joint's name begins with; a thumb joint keeps its whole name."""
    digit = joint.split("_", 1)[0]
    return digit if digit in FINGERS else ""
