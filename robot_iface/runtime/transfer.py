"""A straight way between two postures, played one row a tick."""

from __future__ import annotations

import numpy as np

from robot_iface.motion import Setpoint, plan_transfer, transfer_speeds
from robot_iface.types import Float64, Limits

_ACCELERATION_RAD_S2 = 4.0
_PAUSE_S = 0.25


class Transfer:
    """A straight, jerk-limited way between two postures, one row a tick.

    Args:
        q_from_rad: Where it starts, (J,).
        q_to_rad: Where it ends, (J,).
        limits: Limits of speed.
        period_s: Control period.
    """

    def __init__(self, q_from_rad: Float64, q_to_rad: Float64, limits: Limits, period_s: float) -> None:
        speeds = transfer_speeds(q_from_rad, q_to_rad, limits)
        rows = plan_transfer(q_from_rad, q_to_rad, speeds, _ACCELERATION_RAD_S2, period_s)
        self._rows = rows
        self._rates = np.diff(rows, axis=0, prepend=q_from_rad[None]) / period_s
        self._rates[-1] = 0.0
        self._still = np.zeros(q_from_rad.size)
        self._pace_step = period_s / _PAUSE_S
        self._pace = 1.0
        self._at = 0.0
        self.start = Setpoint(q_from_rad, self._still, self._still)

    @property
    def done(self) -> bool:
        """Whether the end has been given out."""
        return self._at >= len(self._rows)

    @property
    def ticks(self) -> int:
        """How many ticks it takes."""
        return len(self._rows)

    def skip(self) -> None:
        """Take it as done."""
        self._at = float(len(self._rows))

    def step(self, *, paused: bool = False) -> Setpoint:
        """The set-point of the next tick; a pause slows it to rest on its way, at the end it stays there."""
        change = -self._pace_step if paused else self._pace_step
        self._pace = min(max(self._pace + change, 0.0), 1.0)
        self._at = min(self._at + self._pace, float(len(self._rows)))
        low = min(int(self._at), len(self._rows) - 1)
        part = self._at - low if low else 0.0
        rate = self._rates[low] * self._pace
        return Setpoint(self._rows[low] if part == 0.0 else self._between(low, part), rate, self._still)

    def _between(self, low: int, part: float) -> Float64:
        high = min(low + 1, len(self._rows) - 1)
        return self._rows[low] + (self._rows[high] - self._rows[low]) * part
