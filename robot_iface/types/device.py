"""What passes between the control loop and a device, once a tick."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from typing import Literal

from robot_iface.types.hand import Float64

THESIS_INERTIA_KG_M2 = 3e-4
"""Rotor inertia for which the thesis's gains are critically damped; taken where a device states none."""


class CommandMode(IntEnum):
    """What a device does with a command."""

    IMPEDANCE = 0
    TORQUE = 1


@dataclass(frozen=True, slots=True)
class Capabilities:
    """What a device is and can do.

    Attributes:
        name: Device name, such as "exoskeleton".
        simulated: Whether it is a simulation.
        joint_names: The J joints that it drives and measures, all of them names of JOINTS.
        period_ns: Control period that it is made for.
        q_min_rad: Lower end of its own range, (J,).
        q_max_rad: Upper end of its own range, (J,).
        tau_max_nm: Motor cap, (J,).
        worn: Whether a patient's hand is inside it.
        unpowered: What its joints do without power (hazard 5).
        encoder_std_rad: Standard deviation of a joint reading.
        quick_release: Whether a worn device can be opened by hand at once.
        chain: Whose kinematics its joints follow: the patient's hand inside it, or the robot's own.
        position_sensors: How many sensors measure each joint; with 1, ``q_second_rad`` repeats ``q_rad`` and
            no sensor error can be seen.
        inertia_kg_m2: Least inertia that a motor moves, as seen at its joint; bounds what damping is stable.
    """

    name: str
    simulated: bool
    joint_names: tuple[str, ...]
    period_ns: int
    q_min_rad: Float64
    q_max_rad: Float64
    tau_max_nm: Float64
    worn: bool
    unpowered: Literal["free", "damped", "locked"]
    encoder_std_rad: float
    quick_release: bool = False
    chain: Literal["hand", "dlr-hit-ii"] = "hand"
    position_sensors: int = 2
    inertia_kg_m2: float = THESIS_INERTIA_KG_M2


@dataclass(frozen=True, slots=True)
class DeviceState:
    """One reading of a device. Arrays are (J,) in the order of ``Capabilities.joint_names``.

    Attributes:
        t_ns: Time of the reading on the loop's clock.
        seq: Counts readings; a repeated number is a stale state.
        q_rad: Joint positions.
        q_second_rad: The same from the redundant sensor.
        dq_rad_s: Joint velocities.
        tau_nm: Motor torques.
        tau_interaction_nm: Torque of the device on the patient's joint, flexion positive.
        temperature_c: Hottest motor, degrees Celsius.
        faults: Names of device faults, empty when healthy.
    """

    t_ns: int
    seq: int
    q_rad: Float64
    q_second_rad: Float64
    dq_rad_s: Float64
    tau_nm: Float64
    tau_interaction_nm: Float64
    temperature_c: float
    faults: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class DeviceCommand:
    """One command; the device applies tau = K (q_d - q) + D (dq_d - dq) + tau_ff. Arrays are (J,).

    Attributes:
        mode: IMPEDANCE, or TORQUE for the feed-forward torque alone.
        q_rad: Desired positions.
        dq_rad_s: Desired velocities.
        tau_ff_nm: Feed-forward torques.
        stiffness_nm_rad: K.
        damping_nms_rad: D.
        seq: Counts commands.
    """

    mode: CommandMode
    q_rad: Float64
    dq_rad_s: Float64
    tau_ff_nm: Float64
    stiffness_nm_rad: Float64
    damping_nms_rad: Float64
    seq: int
