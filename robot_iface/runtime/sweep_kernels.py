"""The numbers of one tick of a guided sweep, compiled."""

from __future__ import annotations

import numpy as np

from robot_iface.compiled import compiled
from robot_iface.types import Float64

SET, RATE, MULTIPLE, TORQUE, SPEED = range(5)
"""Rows of the table: set-point, its speed, stiffness multiple, feed-forward torque, smoothed speed."""

_ACCELERATION_RAD_S2 = 1.0
_NEAR_PER_S = 4.0  # the last degrees of a way are made ever more slowly
_BAND = 0.2  # of the load at which a joint stops: over this last part it slows down
_RAISE_PER_S = 2.0  # of the stiffness multiple
_INTEGRAL_S = 1.0
_SMOOTH_S = 0.1
_WALL_MULTIPLE = 3.0
_WALL_RAD = float(np.deg2rad(1.0))


@compiled
def lead(
    table: Float64,
    measured: Float64,
    way: Float64,
    goal: Float64,
    bounds: Float64,
    stiffness: Float64,
    multiple: float,
    pace: float,
    period_s: float,
) -> tuple[float, float]:
    """Lead every joint gently towards its goal, until it is there or its load says stop.

    A joint slows down over the last fifth of the load that it may carry and goes back where that is exceeded.
    A feed-forward torque takes over what the spring carries, so that the joint comes to where it is led.

    Args:
        table: Rows as named above, (5, J); changed in place.
        measured: Rows position, speed, interaction torque, (3, J).
        way: +1 where the goal lay in flexion at the start of the way, else -1, (J,).
        goal: Where the joints are led, (J,).
        bounds: Rows low, high, flexion speed, extension speed, stopping load, (5, J).
        stiffness: K at multiple 1, (J,).
        multiple: Stiffness multiple to be reached.
        pace: Share of the speed, 0 for a pause.
        period_s: Control period.

    Returns:
        Largest speed of the set-point and largest smoothed speed of the hand.
    """
    set_speed = 0.0
    hand_speed = 0.0
    for j in range(goal.size):
        stop = bounds[4, j]
        spare = (stop - way[j] * measured[2, j]) / (_BAND * stop)
        spare = min(max(spare, -1.0), 1.0)
        toward = goal[j] - table[SET, j]
        speed = pace * (bounds[2, j] if toward > 0.0 else bounds[3, j])
        wanted = min(max(_NEAR_PER_S * toward, -speed), speed)
        if spare < 0.0:
            back = pace * (bounds[3, j] if way[j] > 0.0 else bounds[2, j])
            wanted = way[j] * back * spare
        elif wanted * way[j] > 0.0:
            wanted *= spare
        most = _ACCELERATION_RAD_S2 * period_s
        rate = table[RATE, j] + min(max(wanted - table[RATE, j], -most), most)
        target = table[SET, j] + rate * period_s
        table[SET, j] = min(max(target, bounds[0, j]), bounds[1, j])
        table[RATE, j] = rate if table[SET, j] == target else 0.0
        rise = _RAISE_PER_S * period_s
        now = table[MULTIPLE, j]
        table[MULTIPLE, j] = now + min(max(multiple - now, -rise), rise)
        gap = table[SET, j] - measured[0, j]
        torque = table[TORQUE, j] + stiffness[j] * table[MULTIPLE, j] * gap * period_s / _INTEGRAL_S
        table[TORQUE, j] = min(max(torque, -stop), stop)
        table[SPEED, j] += (measured[1, j] - table[SPEED, j]) * period_s / _SMOOTH_S
        set_speed = max(set_speed, abs(table[RATE, j]))
        hand_speed = max(hand_speed, abs(table[SPEED, j]))
    return set_speed, hand_speed


@compiled
def free(table: Float64, measured: Float64, bounds: Float64, period_s: float) -> float:
    """Let the hand go, but for a soft wall at the ends of today's range.

    Args:
        table: As for ``lead``.
        measured: As for ``lead``.
        bounds: As for ``lead``.
        period_s: Control period.

    Returns:
        Largest smoothed speed of the hand.
    """
    hand_speed = 0.0
    fall = _RAISE_PER_S * period_s
    for j in range(table.shape[1]):
        inside = min(max(measured[0, j], bounds[0, j]), bounds[1, j])
        beyond = min(abs(measured[0, j] - inside) / _WALL_RAD, 1.0)
        table[SET, j] = inside
        table[RATE, j] = 0.0
        table[MULTIPLE, j] = max(_WALL_MULTIPLE * beyond, table[MULTIPLE, j] - fall)
        table[TORQUE, j] -= table[TORQUE, j] * period_s / _INTEGRAL_S
        table[SPEED, j] += (measured[1, j] - table[SPEED, j]) * period_s / _SMOOTH_S
        hand_speed = max(hand_speed, abs(table[SPEED, j]))
    return hand_speed
