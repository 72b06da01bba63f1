"""When a braked hand has come to rest, so that power can be cut without letting it snap."""

from __future__ import annotations

import numpy as np

from robot_iface.safety.watchdogs import STILL_RAD_S
from robot_iface.types import DeviceState

STILL_FOR_S = 0.1
"""A hand that is held open is still at the instant of the stop; only after a while of braking is that
rest."""
QUIET_SHARE = 0.5
QUIET_FOR_S = 3.0
"""So long without a load above half of its limit. A spasm that holds the hand still does not load the brake,
but it did when it came; spasms last up to 3 s, and while one may last, its release must meet a brake."""
LONGEST_BRAKE_S = 5.0
"""Then power is cut whatever the hand does: a stop of category 1 ends without power."""


class Settling:
    """Counts how long every joint has been slow, how long nothing has pushed hard, and how long it brakes.

    Args:
        period_s: Control period.
    """

    def __init__(self, period_s: float) -> None:
        self._period_s = period_s
        self._still_s = 0.0
        self._quiet_s = QUIET_FOR_S
        self._braked_s = 0.0

    def begin(self) -> None:
        """A brake has just been applied."""
        self._still_s = 0.0
        self._braked_s = 0.0

    def note(self, load_share: float) -> None:
        """Take the load of one tick, in every state: ``Outcome.load_share``."""
        self._quiet_s = self._quiet_s + self._period_s if load_share <= QUIET_SHARE else 0.0

    def over(self, state: DeviceState) -> bool:
        """Take one braked tick; whether power can be cut: the hand rests, or has been braked long enough."""
        slow = float(np.abs(state.dq_rad_s).max()) < STILL_RAD_S
        self._still_s = self._still_s + self._period_s if slow else 0.0
        self._braked_s += self._period_s
        rests = self._still_s >= STILL_FOR_S and self._quiet_s >= QUIET_FOR_S
        return rests or self._braked_s >= LONGEST_BRAKE_S - 0.5 * self._period_s
