"""What must be true before a device is opened, enabled or reset; each refusal is one sentence."""

from __future__ import annotations

import numpy as np

from robot_iface.errors import Refused
from robot_iface.ports import EmergencyStop
from robot_iface.safety.watchdogs import STILL_RAD_S
from robot_iface.types import Capabilities, DeviceState, Limits, SafetyState


def admit_device(
    state: SafetyState, capabilities: Capabilities, limits: Limits, *, quick_release: bool
) -> None:
    """Pass if the device may be opened.

    Raises:
        Refused: If it is open, the limits are for another device, or it would lock fingers without power.
    """
    if state is not SafetyState.OFF:
        raise Refused("supervisor", state.name, "OFF", "close it before starting it again")
    joints = len(capabilities.joint_names)
    if limits.q_min_rad.shape != (joints,):
        value, bound = f"for {limits.q_min_rad.size} joints", f"for the {joints} of the device"
        raise Refused("limits", value, bound, "rebuild the plan for this device")
    if capabilities.worn and capabilities.unpowered == "locked" and not quick_release:
        bound = "free or damped without power, or fitted with a quick release"
        raise Refused(f"device {capabilities.name}", "locked without power", bound, "fit a quick release")


def admit_enable(
    state: SafetyState,
    stop: EmergencyStop,
    reading: DeviceState | None,
    limits: Limits,
    names: tuple[str, ...],
) -> None:
    """Pass if the motors may be powered.

    Raises:
        Refused: If the state is not READY, stop is pressed, or a joint is unread or outside today's range.
    """
    if state is not SafetyState.READY:
        raise Refused("supervisor", state.name, "READY", "reset the stop before enabling")
    if stop.pressed():
        raise Refused("stop", "pressed", "released", "release the stop before enabling")
    if reading is None:
        raise Refused("device", "unread", "read before it is enabled", "call read first")
    low = np.rad2deg(limits.q_min_rad - limits.margin_rad).tolist()
    high = np.rad2deg(limits.q_max_rad + limits.margin_rad).tolist()
    for name, angle, lower, upper in zip(names, np.rad2deg(reading.q_rad).tolist(), low, high, strict=True):
        if not lower <= angle <= upper:
            bound = f"{lower:.1f} to {upper:.1f} degrees"
            raise Refused(f"joint {name}", f"at {angle:.1f} degrees", bound, "bring the hand into its range")


def admit_reset(stop: EmergencyStop, reading: DeviceState | None, *, present: bool) -> None:
    """Pass if a latched state may be left.

    Raises:
        Refused: If nobody is present, stop is still pressed, or a joint moves.
    """
    if not present:
        bound = "made by a person at the device"
        raise Refused("reset", "asked for from afar", bound, "go to the patient")
    if stop.pressed():
        raise Refused("stop", "pressed", "released", "release the stop before the reset")
    speed_rad_s = 0.0 if reading is None else float(np.abs(reading.dq_rad_s).max())
    if not speed_rad_s < STILL_RAD_S:
        value = f"moving at {np.rad2deg(speed_rad_s):.0f} degrees/s"
        raise Refused("hand", value, "still", "wait until it rests, then reset")
