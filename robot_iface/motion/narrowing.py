"""A movement with less range: every joint between new ends, never wider and never faster."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robot_iface.types import Float64

_STILL_RAD = 1e-9


@dataclass(frozen=True, slots=True)
class Narrowing:
    """An affine map of each joint, q -> scale q + shift with scale in [0, 1].

    Attributes:
        table: Scale (row 0) and shift in rad (row 1), (2, J).
    """

    table: Float64

    @property
    def scale(self) -> Float64:
        """Scale of each joint, (J,)."""
        return self.table[0]

    @property
    def shift_rad(self) -> Float64:
        """Shift of each joint, (J,)."""
        return self.table[1]

    def apply(self, q_rad: Float64) -> Float64:
        """Narrowed angles, (..., J)."""
        return self.table[0] * q_rad + self.table[1]


def unchanged(joints: int) -> Narrowing:
    """The narrowing that leaves everything as it is."""
    return Narrowing(np.stack((np.ones(joints), np.zeros(joints))))


def narrowed(low_rad: Float64, high_rad: Float64, floor_rad: Float64, ceiling_rad: Float64) -> Narrowing:
    """The map of a movement's own range into what is left of it between floor and ceiling.

    A joint whose whole range lies beyond a new end stays at the end of its range that is nearer to it; where
    floor and ceiling cross, it stays in the middle between them, within its own range.

    Args:
        low_rad: Least angle of each joint in the movement, (J,).
        high_rad: Greatest, (J,).
        floor_rad: Least angle that is allowed now, (J,).
        ceiling_rad: Greatest, (J,).
    """
    low = np.clip(floor_rad, low_rad, high_rad)
    high = np.clip(ceiling_rad, low_rad, high_rad)
    middle = np.clip(0.5 * (floor_rad + ceiling_rad), low_rad, high_rad)
    crossed = low > high
    low, high = np.where(crossed, middle, low), np.where(crossed, middle, high)
    width = high_rad - low_rad
    moves = width > _STILL_RAD
    scale = np.where(moves, (high - low) / np.where(moves, width, 1.0), 1.0)
    scale = np.minimum(scale, 1.0)
    return Narrowing(np.stack((scale, np.where(moves, low - scale * low_rad, 0.0))))
