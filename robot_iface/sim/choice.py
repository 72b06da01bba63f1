"""Which simulation stands for a device, in a run and in its rehearsal alike."""

from __future__ import annotations

from typing import TypeAlias

from robot_iface.errors import Refused
from robot_iface.sim.dlr_hit_robot import SimulatedDlrHit, dlr_hit_capabilities
from robot_iface.sim.effort import Nobody, PatientEffort
from robot_iface.sim.exoskeleton import SimulatedExoskeleton, device_capabilities
from robot_iface.types import Capabilities, PatientTwin

SIMULATED: tuple[str, ...] = ("exoskeleton", "dlr-hit-ii")
"""Devices that exist as a simulation."""
REAL_PREFIX = "ros2:"
"""What the names of real devices begin with: a hand that is worn, spoken to over ROS 2."""
SimulatedHand: TypeAlias = SimulatedExoskeleton | SimulatedDlrHit
VirtualSide: TypeAlias = PatientEffort | Nobody


def is_real(device: str) -> bool:
    """Whether a name is that of a real device, whether or not it exists."""
    return device.startswith(REAL_PREFIX) and len(device) > len(REAL_PREFIX)


def simulated_capabilities(device: str) -> Capabilities:
    """What a simulated device is and can do, known without building it.

    Raises:
        Refused: There is no such simulation.
    """
    if device == "exoskeleton":
        return device_capabilities()
    if device == "dlr-hit-ii":
        return dlr_hit_capabilities()
    raise unknown_device(device)


def simulated(device: str, twin: PatientTwin, seed: int) -> tuple[SimulatedHand, VirtualSide]:
    """The simulation of a device, and the patient's side of it.

    A real device is rehearsed on the simulated exoskeleton: it is worn as that is, and nothing nearer to it
    is known here.

    Args:
        device: Its name.
        twin: Whose hand is inside; nobody's in a hand that is not worn.
        seed: Seed of everything random.

    Raises:
        Refused: There is no such device, or no such virtual patient.
    """
    if device == "exoskeleton" or is_real(device):
        worn = SimulatedExoskeleton(twin, seed)
        return worn, worn.patient
    if device == "dlr-hit-ii":
        alone = SimulatedDlrHit(seed)
        return alone, alone.patient
    raise unknown_device(device)


def unknown_device(device: str) -> Refused:
    """The refusal of a name that belongs to no device."""
    bound = f"one of {', '.join(SIMULATED)}, or {REAL_PREFIX}NAME"
    return Refused("robot", repr(device), bound, "choose one of these")
