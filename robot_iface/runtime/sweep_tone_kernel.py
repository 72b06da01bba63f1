"""One tick of a stretch at a set speed, compiled."""

from __future__ import annotations

from robot_iface.compiled import compiled
from robot_iface.types import Float64

_SET, _RATE, _TORQUE = 0, 1, 3  # rows of the table of sweep_kernels


@compiled
def stretch(
    table: Float64,
    measured: Float64,
    goal: Float64,
    bounds: Float64,
    wanted: Float64,
    acceleration: Float64,
    loaded: Float64,
    period_s: float,
) -> int:
    """Move every set-point towards its goal at one speed, braking in time; a loaded joint stops for good.

    Args:
        table: Rows set-point, speed, multiple, torque, smoothed speed, (5, J); changed in place.
        measured: Rows position, speed, interaction torque, (3, J).
        goal: Where the joints are led, (J,).
        bounds: Rows low, high, flexion speed, extension speed, stopping load, (5, J).
        wanted: Rows speed into flexion and into extension, (2, J).
        acceleration: Highest acceleration, (J,).
        loaded: 1 where a joint has reached its load, else 0, (J,); changed in place.
        period_s: Control period.

    Returns:
        How many joints are still on their way.
    """
    on_the_way = 0
    for j in range(goal.size):
        toward = goal[j] - table[_SET, j]
        side = 1.0 if toward >= 0.0 else -1.0
        if side * measured[2, j] >= bounds[4, j]:
            loaded[j] = 1.0
        most = acceleration[j] * period_s
        top = wanted[0, j] if side > 0.0 else wanted[1, j]
        braking = (2.0 * acceleration[j] * abs(toward)) ** 0.5
        speed = 0.0 if loaded[j] > 0.0 else side * min(top, braking)
        rate = table[_RATE, j] + min(max(speed - table[_RATE, j], -most), most)
        target = table[_SET, j] + rate * period_s
        table[_SET, j] = min(max(target, bounds[0, j]), bounds[1, j])
        table[_RATE, j] = rate if table[_SET, j] == target else 0.0
        table[_TORQUE, j] -= table[_TORQUE, j] * period_s
        if loaded[j] == 0.0 and abs(toward) > 0.02:
            on_the_way += 1
    return on_the_way
