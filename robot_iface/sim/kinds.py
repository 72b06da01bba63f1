"""Virtual patients: one row of parameters each."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from robot_iface.errors import Refused
from robot_iface.types import FINGERS, JOINTS, Float64, PatientTwin

STIFFNESS_NM_RAD = (0.01, 1.5)
"""Passive MCP stiffness that a record may state; hands of MAS 1+ to 3 are sampled from .03 to .9."""
Will = Literal["none", "follow", "slack", "resist"]


@dataclass(frozen=True, slots=True)
class VirtualPatient:
    """What one virtual patient's hand does.

    Attributes:
        stiffness_nm_rad: Passive stiffness of an MCP joint (Front Bioeng Biotech 2020, 592637, Table 2); PIP
            alike, DIP 0.6 of it.
        damping_nms_rad: Passive damping of a joint.
        ability: Voluntary effort, 0 none to 1 sound: scales a servo to an equilibrium posture.
        will: What the patient does when cued: nothing, follow the movement, follow it the less the better the
            robot does it (slack), or hold the resting posture, cued or not (resist).
        spasticity_nms_rad: Reflex torque into flexion per speed of extension beyond 30 deg/s, 30 ms and a
            muscle's twitch late (shape after Kamper & Rymer 2000; size, and its bounds of 0.5 Nm at the first
            joint of a digit and 0.3 Nm beyond, assumed).
        tremor_nm: Amplitude of a 5 Hz tremor torque at the MCP joints.
        flexed: Rests with the fingers drawn in, as a spastic hand does.
        block_rad: Contracture: how far from rest a flexion joint can be extended before its tissue ends; 0
            for no such end within the device's range.
        block_nm_rad: Stiffness beyond that end.
        clonus_nm: Largest torque of the 5 to 7 Hz beats that a fast stretch sets off (size assumed).
        tires_j: Work of the muscles, in J over the whole hand, that brings ability down to 37 %; infinite for
            a patient who does not tire (size assumed). A repetition costs 0.04 to 0.24 J, recovered from in
            ten minutes: one every 12.5 s (289 an hour) tires within 20 to 100 repetitions, 32 in a session
            of 45 minutes do not.
    """

    stiffness_nm_rad: float
    damping_nms_rad: float = 0.002
    ability: float = 0.0
    will: Will = "none"
    spasticity_nms_rad: float = 0.0
    tremor_nm: float = 0.0
    flexed: bool = False
    block_rad: float = 0.0
    block_nm_rad: float = 0.0
    clonus_nm: float = 0.0
    tires_j: float = float("inf")

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
    "contracture": VirtualPatient(
        0.30,
        damping_nms_rad=0.004,
        ability=0.6,
        will="follow",
        flexed=True,
        block_rad=float(np.deg2rad(25.0)),
        block_nm_rad=4.0,
    ),
    "clonus": VirtualPatient(
        0.090, ability=0.3, will="follow", spasticity_nms_rad=0.06, flexed=True, clonus_nm=0.08
    ),
    "tiring": VirtualPatient(0.040, ability=0.7, will="follow", tires_j=3.0),
    "tremor": VirtualPatient(0.040, ability=0.7, will="follow", tremor_nm=0.03),
    "slacking": VirtualPatient(0.100, ability=0.6, will="slack"),
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


def patient_of(twin: PatientTwin) -> VirtualPatient:
    """The virtual patient of a record: that of its kind, with the stiffness that was measured.

    Raises:
        Refused: There is no such kind, or no hand is so soft or so stiff.
    """
    patient = virtual_patient(twin.kind)
    if twin.stiffness_nm_rad == 0.0:
        return patient
    low, high = STIFFNESS_NM_RAD
    if not low <= twin.stiffness_nm_rad <= high:
        value, bound = f"{twin.stiffness_nm_rad:g} Nm/rad", f"{low:g} to {high:g} Nm/rad"
        raise Refused("stiffness of the MCP joint", value, bound, "measure it again, or leave it at 0")
    return replace(patient, stiffness_nm_rad=twin.stiffness_nm_rad)


def _finger(joint: str) -> str:
    """The finger that a joint's name begins with; a thumb joint keeps its whole name."""
    digit = joint.split("_", 1)[0]
    return digit if digit in FINGERS else ""
