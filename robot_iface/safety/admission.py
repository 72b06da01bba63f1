"""What must be true before a device is opened, enabled or reset; each refusal is one sentence."""

from __future__ import annotations

import datetime

import numpy as np

from robot_iface.errors import Refused
from robot_iface.ports import EmergencyStop
from robot_iface.safety.hulls import pack_hulls
from robot_iface.safety.shipped import MOTOR_CAP_NM, THERAPIST_CAP_NM
from robot_iface.safety.watchdogs import STILL_RAD_S
from robot_iface.types import Capabilities, DeviceState, Limits, SafetyState

WRIST_RAD = float(np.deg2rad(10.0))
"""A wrist that is held by more than this from where the range was measured changes every finger's range."""
FASTEST_TRIP_RAD_S = float(np.deg2rad(200.0))
WIDEST_MARGIN_RAD = float(np.deg2rad(2.0))
_ROUNDING = 1e-9
_REBUILD = "rebuild the plan for this device"
_MEASURE = "measure today's range again"


def admit_limits(limits: Limits, capabilities: Capabilities, wrist_rad: float, now_utc_ns: int) -> None:
    """Pass if these limits may protect this patient on this device now; asked before anything is opened.

    Args:
        limits: Limits of a plan.
        capabilities: The device that it is for.
        wrist_rad: Wrist extension at which the hand is held today.
        now_utc_ns: Time of day, ns since 1970 UTC.

    Raises:
        Refused: They are for other joints, have expired, were measured at another wrist angle, reach beyond
            the device's range, or are wider than even a therapist may make them.
    """
    admit_shape(limits, capabilities)
    if limits.expires_utc_ns and not now_utc_ns < limits.expires_utc_ns:
        expired = datetime.datetime.fromtimestamp(limits.expires_utc_ns * 1e-9, datetime.UTC)
        raise Refused("limits", f"expired since {expired:%Y-%m-%d %H:%M} UTC", "of today", _MEASURE)
    if not np.isnan(limits.wrist_rad) and not abs(wrist_rad - limits.wrist_rad) <= WRIST_RAD + _ROUNDING:
        bound = (
            f"within {np.rad2deg(WRIST_RAD):.0f} degrees of the measured {np.rad2deg(limits.wrist_rad):.0f}"
        )
        raise Refused(
            "wrist", f"at {np.rad2deg(wrist_rad):.0f} degrees", bound, f"turn it back or {_MEASURE}"
        )
    _admit_torques(limits, capabilities.joint_names)
    _admit_trips(limits)
    _admit_range(limits, capabilities)
    pack_hulls(limits, capabilities.joint_names)


def admit_device(state: SafetyState, capabilities: Capabilities) -> None:
    """Pass if the device may be opened.

    Raises:
        Refused: If it is open, or it would lock fingers without power.
    """
    if state is not SafetyState.OFF:
        raise Refused("supervisor", state.name, "OFF", "close it before starting it again")
    if capabilities.worn and capabilities.unpowered == "locked" and not capabilities.quick_release:
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
    pair = pack_hulls(limits, names).outside(reading.q_rad, limits.margin_rad)
    if pair:
        bound = "within the common range of both"
        raise Refused(f"joints {pair}", "outside it together", bound, "bring the hand into its range")


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


def admit_shape(limits: Limits, capabilities: Capabilities) -> None:
    """Pass if the limits are for as many joints as the device drives.

    Raises:
        Refused: They are not.
    """
    joints = len(capabilities.joint_names)
    if limits.q_min_rad.shape != (joints,):
        value, bound = f"for {limits.q_min_rad.size} joints", f"for the {joints} of the device"
        raise Refused("limits", value, bound, _REBUILD)


def _admit_torques(limits: Limits, names: tuple[str, ...]) -> None:
    """What the patient may be loaded with, and what the motors may be commanded, joint by joint."""
    rows = (
        ("interaction torque", limits.tau_interaction_nm.tolist(), THERAPIST_CAP_NM),
        ("motor torque", limits.tau_nm.tolist(), MOTOR_CAP_NM),
    )
    for what, torques, cap_nm in rows:
        for name, torque in zip(names, torques, strict=True):
            if not 0.0 < torque <= cap_nm + _ROUNDING:
                value, bound = f"{torque:.3g} Nm", f"above 0, at most {cap_nm:g} Nm"
                raise Refused(f"{what} of {name}", value, bound, "lower the limit")


def _admit_trips(limits: Limits) -> None:
    """What trips the supervisor is no matter of a plan."""
    speed, margin = np.rad2deg([limits.trip_speed_rad_s, limits.margin_rad]).tolist()
    if not 0.0 < limits.trip_speed_rad_s <= FASTEST_TRIP_RAD_S + _ROUNDING:
        raise Refused("trip speed", f"{speed:.0f} degrees/s", "above 0, at most 200", "use the shipped one")
    if not 0.0 <= limits.margin_rad <= WIDEST_MARGIN_RAD + _ROUNDING:
        raise Refused("margin of the range", f"{margin:.1f} degrees", "0 to 2", "use the shipped one")


def _admit_range(limits: Limits, capabilities: Capabilities) -> None:
    """Today's range lies within what the device can make."""
    ends = (limits.q_min_rad, limits.q_max_rad, capabilities.q_min_rad, capabilities.q_max_rad)
    rows = np.rad2deg(np.stack(ends)).T.tolist()
    for name, (low, high, lowest, highest) in zip(capabilities.joint_names, rows, strict=True):
        if not lowest - 1e-6 <= low < high <= highest + 1e-6:
            value = f"{low:.1f} to {high:.1f} degrees"
            bound = f"within the device's {lowest:.1f} to {highest:.1f}"
            raise Refused(f"range of {name}", value, bound, _REBUILD)
