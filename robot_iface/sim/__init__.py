"""Simulated devices with a virtual patient's hand in them."""

from robot_iface.sim.exoskeleton import SimulatedExoskeleton, device_capabilities
from robot_iface.sim.faults import Fault, FaultInjector, FaultKind
from robot_iface.sim.kinds import VirtualPatient, virtual_patient
from robot_iface.sim.model import DRIVEN, HandModel, build_model, hand_landmarks

__all__ = [
    "DRIVEN",
    "Fault",
    "FaultInjector",
    "FaultKind",
    "HandModel",
    "SimulatedExoskeleton",
    "VirtualPatient",
    "build_model",
    "device_capabilities",
    "hand_landmarks",
    "virtual_patient",
]
