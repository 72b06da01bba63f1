"""The static bound of runs in which the patient moves: the law may help or oppose, but never drive.

No path says where the hand will be when the patient moves alone, so no dry run covers what may happen. What
can be said beforehand is said of the law itself: over all loads and speeds that the limits admit, without
stiffness, it gives the hand no more power than a share below one of what the patient puts in, and no torque
above the patient's limit.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robot_iface.control import Goal, Law, make_law
from robot_iface.motion import PathState, Setpoint
from robot_iface.types import Capabilities, DeviceCommand, DeviceState, Float64, Plan

ASKED_FEEDBACK = 1.0
"""More than any run asks for: the law itself must keep below it."""
MOST_SHARE = 0.96
"""Of the patient's own power, so much may be given back; at one, the hand would run by itself."""
_SETTLED_TICKS = 150  # by then the law's own filters have settled
_LOADS = (-1.0, -0.5, -0.1, 0.0, 0.1, 0.5, 1.0)
_SPEEDS = (-1.0, -0.3, -0.05, 0.0, 0.05, 0.3, 1.0)
_ROUNDING_W = 1e-6
_ROUNDING_NM = 1e-9


@dataclass(frozen=True, slots=True)
class _Tried:
    """One state of all joints and what the law does there. Arrays (J,).

    Attributes:
        load_nm: Interaction torque.
        speed_rad_s: Speed.
        tau_nm: Torque of the command at that speed.
    """

    load_nm: Float64
    speed_rad_s: Float64
    tau_nm: Float64


def first_driven(plan: Plan, capabilities: Capabilities) -> str:
    """The first joint that the law would drive or overload, as a sentence; empty if there is none.

    Args:
        plan: A plan in which the patient moves: transparent, resistive, or a sweep's active part.
        capabilities: The device.
    """
    law = make_law(plan, capabilities)
    resistive = plan.sweep is None and plan.prescription.mode == "resistive"
    feedback = 0.0 if resistive else ASKED_FEEDBACK
    opposition = plan.prescription.resistance if resistive else 0.0
    for load in _LOADS:
        for speed in _SPEEDS:
            tried = _settled(plan, law, (load, speed), (feedback, opposition))
            found = _exceeded(plan, tried)
            if found:
                return found
    return ""


def _settled(plan: Plan, law: Law, shares: tuple[float, float], asked: tuple[float, float]) -> _Tried:
    """What the law does at a state that lasts."""
    limits = plan.limits
    joints = limits.q_min_rad.size
    still = np.zeros(joints)
    middle = 0.5 * (limits.q_min_rad + limits.q_max_rad)
    load = shares[0] * limits.tau_interaction_nm
    speed = np.full(joints, shares[1] * limits.trip_speed_rad_s)
    state = DeviceState(0, 0, middle, middle, speed, still, load, 25.0, ())
    goal = Goal(
        Setpoint(middle, still, still),
        still,
        still,
        PathState(0.0, 0.0, 0.0, False),
        feedback=asked[0],
        opposition=asked[1],
    )
    command = law.command(state, goal, 1.0, 0)
    for tick in range(1, _SETTLED_TICKS):
        command = law.command(state, goal, 1.0, tick)
    return _Tried(load, speed, _torque(command, state))


def _torque(command: DeviceCommand, state: DeviceState) -> Float64:
    spring = command.stiffness_nm_rad * (command.q_rad - state.q_rad)
    return command.tau_ff_nm + spring + command.damping_nms_rad * (command.dq_rad_s - state.dq_rad_s)


def _exceeded(plan: Plan, tried: _Tried) -> str:
    power_w = tried.tau_nm * tried.speed_rad_s
    given_w = np.maximum(
        -tried.load_nm * tried.speed_rad_s, 0.0
    )  # by the patient, whose push is minus the load
    allowed_w = MOST_SHARE * given_w + _ROUNDING_W
    driven = power_w - allowed_w
    joint = int(np.argmax(driven))
    if float(driven[joint]) > 0.0:
        return _sentence(plan, tried, joint, f"{power_w[joint]:.3g} W", f"{allowed_w[joint]:.3g} W")
    at_rest = tried.speed_rad_s == 0.0
    excess = np.where(at_rest, np.abs(tried.tau_nm) - plan.limits.tau_interaction_nm - _ROUNDING_NM, -1.0)
    joint = int(np.argmax(excess))
    if float(excess[joint]) > 0.0:
        bound = f"{plan.limits.tau_interaction_nm[joint]:.3g} Nm"
        return _sentence(plan, tried, joint, f"{abs(tried.tau_nm[joint]):.3g} Nm", bound)
    return ""


def _sentence(plan: Plan, tried: _Tried, joint: int, value: str, bound: str) -> str:
    speed = float(np.rad2deg(tried.speed_rad_s[joint]))
    return (
        f"{plan.joint_names[joint]} would be driven with {value}, bound {bound}, "
        f"at {speed:.0f}°/s and a load of {tried.load_nm[joint]:.2f} Nm"
    )
