"""How fast a reference moves its joints, measured against their directed speed limits."""

from __future__ import annotations

import numpy as np

from robot_iface.motion import QuinticPath
from robot_iface.types import Limits
from sessions.records.fields import Float64

SAMPLE_S = 0.005
"""Distance of the instants at which speeds are looked at: a quarter of that of the knots."""
SPEED_MARGIN = 0.98
"""Share of a speed limit that a path may use, as it is looked at only so often."""


def speed_share(spline: QuinticPath, path_s: Float64, limits: Limits) -> Float64:
    """Speed of each joint as a share of its limit for the direction in which it moves, at full speed.

    Args:
        spline: The path.
        path_s: Path coordinates, shape (n,).
        limits: Bounds of its J joints.

    Returns:
        Shares, shape (n, J), 0 or more; above 1 a limit is broken.
    """
    rad_s = spline.sample(path_s, 1)
    return np.maximum(rad_s / limits.flexion_speed_rad_s, -rad_s / limits.extension_speed_rad_s)


def instants(duration_s: float) -> Float64:
    """Equally spaced path coordinates from 0 to the end, at most 5 ms apart, shape (n,)."""
    return np.linspace(0.0, duration_s, max(8, int(np.ceil(duration_s / SAMPLE_S))) + 1)


def fastest(spline: QuinticPath, limits: Limits) -> tuple[float, str]:
    """Largest path speed, at most 1, at which the path keeps its speed limits, and what sets it."""
    path_s = instants(spline.duration_s)
    share = speed_share(spline, path_s, limits)
    row, joint = divmod(int(np.argmax(share)), share.shape[1])
    worst = float(share[row, joint])
    if worst <= 1.0:
        return 1.0, ""
    moves, allowed = speed_words(spline, float(path_s[row]), joint, limits, 1.0)
    reason = f"{spline.joint_names[joint]} moves at {moves} at {path_s[row]:.2f} s of full speed, {allowed}"
    return min(1.0, SPEED_MARGIN / worst), reason


def speed_words(
    spline: QuinticPath, path_s: float, joint: int, limits: Limits, speed: float
) -> tuple[str, str]:
    """How fast a joint moves at one instant and what is allowed, as a person reads it.

    Args:
        spline: The path.
        path_s: The instant.
        joint: Which of the path's joints.
        limits: Bounds of those joints.
        speed: Path speed.

    Returns:
        Such as "148 deg/s into extension" and "30 deg/s are allowed".
    """
    rad_s = speed * float(spline.sample(np.array([path_s]), 1)[0, joint])
    bounds = limits.flexion_speed_rad_s if rad_s > 0 else limits.extension_speed_rad_s
    way = "flexion" if rad_s > 0 else "extension"
    moves = f"{abs(np.rad2deg(rad_s)):.0f} deg/s into {way}"
    return moves, f"{np.rad2deg(bounds[joint]):.0f} deg/s are allowed"
