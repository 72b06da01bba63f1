"""The only place that chooses device and clock of a run, and the way in to the simulated reach and grasp."""

from __future__ import annotations

from robot_iface.adapters.advice import real_device_advice
from robot_iface.adapters.device_file import device_names
from robot_iface.adapters.ros2 import open_ros2, ros2_capabilities
from robot_iface.errors import Refused
from robot_iface.loop import PacedSimulatedClock, RealTimeClock, SimulatedClock
from robot_iface.runtime import PresentPatient, Rig
from robot_iface.sim.choice import SIMULATED, is_real, simulated, simulated_capabilities
from robot_iface.sim.reach import Grasp, reach_and_grasp
from robot_iface.sim.reach_drawing import draw_reach
from robot_iface.sim.reach_world import FreeCylinder
from robot_iface.types import Capabilities, Plan

__all__ = [
    "DEVICES",
    "FreeCylinder",
    "Grasp",
    "capabilities",
    "device_names",
    "draw_reach",
    "open_rig",
    "reach_and_grasp",
    "real_device_advice",
]

DEVICES: tuple[str, ...] = SIMULATED
"""Devices that are always there; a real one has its own name (``ros2:NAME``) and is never the default."""


def capabilities(device: str) -> Capabilities:
    """What a device is and can do, known without opening it.

    Raises:
        Refused: There is no such device.
    """
    return ros2_capabilities(device) if is_real(device) else simulated_capabilities(device)


def open_rig(plan: Plan) -> Rig:
    """Device, clock and patient for a plan; nothing is opened or powered yet.

    Raises:
        Refused: There is no such device or virtual patient; or the device is real and nobody has confirmed
            it, the run is not one in real time, or what speaks to it is not installed.
    """
    if is_real(plan.device):
        return _real_rig(plan)
    robot, patient = simulated(plan.device, plan.twin, plan.seed)
    period_ns = robot.capabilities.period_ns
    if plan.realtime:
        return Rig(robot, PacedSimulatedClock(period_ns, robot.advance), patient)
    return Rig(robot, SimulatedClock(period_ns, robot.advance), patient)


def _real_rig(plan: Plan) -> Rig:
    """A real device never moves by default: a person has named it and confirmed it, and time is real."""
    if plan.confirmed_device != plan.device:
        confirmed = repr(plan.confirmed_device) if plan.confirmed_device else "not confirmed"
        remedy = "look at the device and confirm it by its name"
        raise Refused(f"real device {plan.device}", confirmed, "confirmed by its own name", remedy)
    if not plan.realtime:
        remedy = "start it on the wall clock, or choose a simulation"
        raise Refused(f"real device {plan.device}", "on simulated time", "on real time", remedy)
    robot = open_ros2(plan.device)
    return Rig(robot, RealTimeClock(robot.capabilities.period_ns), PresentPatient())
