"""The static check of a whole path, before anything moves."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from robot_iface.motion.path import QuinticPath
from robot_iface.types import Float64, Limits

Quantity = Literal["angle", "flexion speed", "extension speed"]
_ROUNDING = 1e-9
_CHUNK = 20_000


@dataclass(frozen=True, slots=True)
class Violation:
    """The first place where a path leaves the limits.

    Attributes:
        joint: Joint concerned.
        quantity: What is out of bounds.
        t_s: Time from the start of the movement at the checked speed.
        value: Value met, rad or rad/s; extension speeds are given as positive numbers.
        bound: Bound that applies, in the same unit.
    """

    joint: str
    quantity: Quantity
    t_s: float
    value: float
    bound: float

    def sentence(self) -> str:
        """The violation as a person reads it, in degrees."""
        unit = "°" if self.quantity == "angle" else "°/s"
        value, bound = float(np.rad2deg(self.value)), float(np.rad2deg(self.bound))
        return (
            f"{self.joint} {self.quantity} is {value:.1f}{unit} at {self.t_s:.2f} s, bound {bound:.1f}{unit}"
        )


def check_path(path: QuinticPath, limits: Limits, speed: float, period_s: float) -> Violation | None:
    """The first violation of range or of directed speed along the whole path, or None.

    The path is sampled at every tick of a player that is already at ``speed``, and at its end: between
    knots as well as on them. The real player is never faster, so a path that passes here is within the
    speeds wherever it is played.

    Args:
        path: The path.
        limits: Bounds of the driven joints, in the order of the path.
        speed: Path speed that will be requested.
        period_s: Control period.

    Returns:
        The earliest violation; at one instant, the one that exceeds its bound most.
    """
    step = speed * period_s
    samples = int(np.ceil(path.duration_s / step))
    for first in range(0, samples + 1, _CHUNK):
        ticks = np.arange(first, min(first + _CHUNK, samples + 1), dtype=np.float64)
        path_s = np.minimum(ticks * step, path.duration_s)
        found = _first_in(path, limits, speed, path_s)
        if found is not None:
            return found
    return None


def _first_in(path: QuinticPath, limits: Limits, speed: float, path_s: Float64) -> Violation | None:
    """First violation among the sampled coordinates, (n,)."""
    q = path.sample(path_s)
    dq = path.sample(path_s, 1) * speed
    rows: tuple[tuple[Quantity, Float64, Float64, float], ...] = (
        ("angle", q, limits.q_max_rad, 1.0),
        ("angle", -q, -limits.q_min_rad, -1.0),
        ("flexion speed", dq, limits.flexion_speed_rad_s, 1.0),
        ("extension speed", -dq, limits.extension_speed_rad_s, 1.0),
    )
    excess = np.stack([value - bound for _, value, bound, _ in rows])
    bad = excess.max(axis=(0, 2)) > _ROUNDING
    if not bool(bad.any()):
        return None
    tick = int(np.argmax(bad))
    row, joint = divmod(int(np.argmax(excess[:, tick])), q.shape[1])
    quantity, value, bound, sign = rows[row]
    return Violation(
        path.joint_names[joint],
        quantity,
        float(path_s[tick]) / speed,
        sign * float(value[tick, joint]),
        sign * float(bound[joint]),
    )
