"""Compiled numerics of a path: what is asked for in every tick."""

from __future__ import annotations

from robot_iface.compiled import compiled
from robot_iface.types import Float64


@compiled
def point_on_path(
    coefficients: Float64,
    starts: Float64,
    narrowing: Float64,
    path_s: float,
    path_speed: float,
    path_acceleration: float,
    out: Float64,
) -> None:
    """Positions, velocities and accelerations of a quintic spline at a moving coordinate.

    Args:
        coefficients: Of each piece at its left knot, highest power first, (P, 6, J).
        starts: Left knots, (P,).
        narrowing: Scale and shift of each joint, (2, J).
        path_s: Path coordinate, on the path.
        path_speed: ds/dt.
        path_acceleration: d2s/dt2.
        out: Is filled with q, q' and q'' in time, (3, J).
    """
    low, high = 0, starts.shape[0]
    while high - low > 1:
        middle = (low + high) // 2
        if starts[middle] <= path_s:
            low = middle
        else:
            high = middle
    u = path_s - starts[low]
    square = path_speed * path_speed
    for joint in range(out.shape[1]):
        c0, c1, c2 = coefficients[low, 0, joint], coefficients[low, 1, joint], coefficients[low, 2, joint]
        c3, c4, c5 = coefficients[low, 3, joint], coefficients[low, 4, joint], coefficients[low, 5, joint]
        scale = narrowing[0, joint]
        q = ((((c0 * u + c1) * u + c2) * u + c3) * u + c4) * u + c5
        slope = (((5.0 * c0 * u + 4.0 * c1) * u + 3.0 * c2) * u + 2.0 * c3) * u + c4
        curvature = ((20.0 * c0 * u + 12.0 * c1) * u + 6.0 * c2) * u + 2.0 * c3
        out[0, joint] = scale * q + narrowing[1, joint]
        out[1, joint] = scale * slope * path_speed
        out[2, joint] = scale * (curvature * square + slope * path_acceleration)
