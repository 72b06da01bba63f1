"""Which way a path is going, as a person who is asked to follow it would say."""

from __future__ import annotations

import numpy as np

from robot_iface.motion import QuinticPath
from robot_iface.types import Float64

_HEADING_RAD = float(np.deg2rad(3.0))
_CUED_RAD = float(np.deg2rad(5.0))  # the cued direction is that of the first 5 degrees of the path


def headings(path_rad: Float64) -> Float64:
    """Where the path is going at each of its postures, even where it stands still: to 3 degrees on.

    Args:
        path_rad: Postures along the path, (M, J).

    Returns:
        Directions, (M, J); zero where nothing 3 degrees away follows.
    """
    headings = np.zeros_like(path_rad)
    ahead = 0
    for here in range(len(path_rad)):
        ahead = max(ahead, here)
        while ahead < len(path_rad) and float(np.abs(path_rad[ahead] - path_rad[here]).max()) < _HEADING_RAD:
            ahead += 1
        if ahead == len(path_rad):
            break
        headings[here] = path_rad[ahead] - path_rad[here]
    return headings


def cued_direction(path: QuinticPath) -> Float64:
    """Displacement over the first 5 degrees of the path (or to its farthest point), (J,)."""
    away = path.sample(np.linspace(0.0, path.duration_s, 400)) - path.start_rad()
    reach = np.abs(away).max(axis=1)
    far = reach >= _CUED_RAD
    return away[int(np.argmax(far))] if bool(far.any()) else away[int(np.argmax(reach))]
