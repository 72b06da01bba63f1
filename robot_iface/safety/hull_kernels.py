"""Plane geometry of one convex polygon, compiled: how far outside, and where is the nearest point?"""

from __future__ import annotations

from robot_iface.compiled import compiled
from robot_iface.types import Float64


@compiled
def nearest_in(x: float, y: float, corners: Float64, start: int, stop: int) -> tuple[float, float]:
    """The point of a convex polygon that is nearest to (x, y); the point itself if it lies within.

    Args:
        x: First coordinate.
        y: Second coordinate.
        corners: Corners, counter-clockwise, among those of other polygons, (C, 2).
        start: Its first corner.
        stop: The corner after its last.
    """
    inside = True
    best, best_x, best_y = 1e300, x, y
    ax, ay = corners[stop - 1, 0], corners[stop - 1, 1]
    for index in range(start, stop):
        bx, by = corners[index, 0], corners[index, 1]
        ex, ey = bx - ax, by - ay
        if ex * (y - ay) - ey * (x - ax) < 0.0:
            inside = False
            along = ((x - ax) * ex + (y - ay) * ey) / (ex * ex + ey * ey)
            along = min(max(along, 0.0), 1.0)
            nx, ny = ax + along * ex, ay + along * ey
            square = (x - nx) * (x - nx) + (y - ny) * (y - ny)
            if square < best:
                best, best_x, best_y = square, nx, ny
        ax, ay = bx, by
    if inside:
        return x, y
    return best_x, best_y


@compiled
def distance_outside(x: float, y: float, corners: Float64, start: int, stop: int) -> float:
    """How far a point is from a convex polygon, 0 within; see ``nearest_in``."""
    nx, ny = nearest_in(x, y, corners, start, stop)
    return float(((x - nx) * (x - nx) + (y - ny) * (y - ny)) ** 0.5)
