"""Simulated devices with a virtual patient's hand in them."""

from robot_iface.sim.choice import SIMULATED, is_real, simulated, simulated_capabilities
from robot_iface.sim.dlr_hit_robot import DLR_HIT_JOINTS, SimulatedDlrHit, dlr_hit_capabilities
from robot_iface.sim.exoskeleton import SimulatedExoskeleton, device_capabilities
from robot_iface.sim.faults import Fault, FaultInjector, FaultKind
from robot_iface.sim.kinds import VirtualPatient, patient_of, virtual_patient
from robot_iface.sim.model import DRIVEN, HandModel, build_model, hand_landmarks

__all__ = [
    "DLR_HIT_JOINTS",
    "DRIVEN",
    "SIMULATED",
    "Fault",
    "FaultInjector",
    "FaultKind",
    "HandModel",
    "SimulatedDlrHit",
    "SimulatedExoskeleton",
    "VirtualPatient",
    "build_model",
    "device_capabilities",
    "dlr_hit_capabilities",
    "hand_landmarks",
    "is_real",
    "patient_of",
    "simulated",
    "simulated_capabilities",
    "virtual_patient",
]
