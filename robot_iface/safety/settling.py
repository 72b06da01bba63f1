"""When a braked hand has come to rest, so that power can be cut without letting it snap."""

from __future__ import annotations

import numpy as np

from robot_iface.safety.watchdogs import STILL_RAD_S
from robot_iface.types import DeviceState

STILL_FOR_S = 0.1
"""A hand that is held open is still at the instant of the stop; only after a while of braking is that
rest."""


class Settling:
    """Counts how long every joint has been slower than 5 deg/s.

    Args:
        period_s: Control period.
    """

    def __init__(self, period_s: float) -> None:
        self._period_s = period_s
        self._still_s = 0.0

    def begin(self) -> None:
        """A brake has just been applied."""
        self._still_s = 0.0

    def still(self, state: DeviceState) -> bool:
        """Take one tick; whether the hand has been at rest for 0.1 s."""
        slow = float(np.abs(state.dq_rad_s).max()) < STILL_RAD_S
        self._still_s = self._still_s + self._period_s if slow else 0.0
        return self._still_s >= STILL_FOR_S
