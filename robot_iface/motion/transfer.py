"""Straight transfers between postures: the approach to a path and the return from it."""

from __future__ import annotations

from typing import Any

import numpy as np
from ruckig import InputParameter, Result, Ruckig, RuckigError, Synchronization, Trajectory

from robot_iface.errors import Refused
from robot_iface.types import Float64, Limits

_JERK_PER_ACCELERATION_HZ = 10.0
_MAX_TICKS = 600_000


def transfer_speeds(q_from_rad: Float64, q_to_rad: Float64, limits: Limits) -> Float64:
    """Speed limit of each joint for the direction in which a transfer moves it, (J,) rad/s."""
    flexing = q_to_rad >= q_from_rad
    return np.where(flexing, limits.flexion_speed_rad_s, limits.extension_speed_rad_s)


def plan_transfer(
    q_from_rad: Float64,
    q_to_rad: Float64,
    speed_limit_rad_s: Float64,
    acceleration_rad_s2: float,
    period_s: float,
) -> Float64:
    """Positions of a jerk-limited transfer from rest to rest, every joint on the same straight line.

    Args:
        q_from_rad: Where it starts, (J,).
        q_to_rad: Where it ends, (J,).
        speed_limit_rad_s: Highest speed of each joint, (J,).
        acceleration_rad_s2: Highest acceleration of every joint.
        period_s: Control period.

    Returns:
        Positions of the ticks after the start, (n, J), n >= 1; the last row is exactly ``q_to_rad``.

    Raises:
        Refused: If a bound is not positive, an angle is not finite, or the transfer takes more than 600 000
            ticks.
    """
    if not (np.isfinite(q_from_rad).all() and np.isfinite(q_to_rad).all()):
        raise Refused("transfer", "not finite", "finite angles", "check the device's readings")
    if not (bool(np.all(speed_limit_rad_s > 0.0)) and acceleration_rad_s2 > 0.0):
        raise Refused("transfer speed", "zero or less", "more than 0", "check the limits")
    trajectory = _profile(q_from_rad, q_to_rad, speed_limit_rad_s, acceleration_rad_s2, period_s)
    ticks = max(int(np.ceil(float(trajectory.duration) / period_s - 1e-9)), 1)
    if ticks > _MAX_TICKS:
        raise Refused("transfer", f"{ticks} ticks long", f"at most {_MAX_TICKS}", "raise the speed limits")
    rows = np.array([trajectory.at_time((tick + 1) * period_s)[0] for tick in range(ticks)], dtype=np.float64)
    rows[-1] = q_to_rad
    return rows


def _profile(q_from: Float64, q_to: Float64, speed: Float64, acceleration: float, period_s: float) -> Any:
    """The time-optimal synchronised profile of the generator."""
    joints = q_from.size
    wanted: Any = InputParameter(joints)
    wanted.synchronization = Synchronization.Phase
    wanted.current_position = q_from.tolist()
    wanted.target_position = q_to.tolist()
    wanted.max_velocity = speed.tolist()
    wanted.max_acceleration = [acceleration] * joints
    wanted.max_jerk = [acceleration * _JERK_PER_ACCELERATION_HZ] * joints
    trajectory: Any = Trajectory(joints)
    try:
        result = Ruckig(joints, period_s).calculate(wanted, trajectory)
    # Results that its own enumeration lacks (a trajectory that lasts too long) arrive as ValueError.
    except (RuckigError, ValueError) as error:
        raise Refused("transfer", f"refused ({error})", "solvable", "check limits and postures") from error
    if result not in (Result.Working, Result.Finished):
        raise Refused("transfer", f"refused ({result})", "solvable", "check limits and postures")
    return trajectory
