"""How much torque may pass: it rises after an enable, and again after a load was gone back on."""

from __future__ import annotations

REGAINED_FROM = 0.5
"""After going back on a load, the clamp begins at this share of itself and rises to all of it as in RAMP_IN.
From nothing it left a trembling hand without damping: 138 deg/s against 110 unsupervised."""


class Ramp:
    """Two shares that rise to 1 in the same time.

    Args:
        step: By how much a tick.
    """

    def __init__(self, step: float) -> None:
        self.share = 0.0
        """Share of torque since the enable, 0 to 1."""
        self._regained = 1.0
        self._step = step

    @property
    def clamp(self) -> float:
        """Share of the torque clamp that applies now."""
        return self.share * self._regained

    def begin(self) -> None:
        """Nothing passes."""
        self.share, self._regained = 0.0, 1.0

    def begin_again(self) -> None:
        """The hand is given back after a load was gone back on."""
        self._regained = REGAINED_FROM

    def advance(self) -> bool:
        """One tick; whether all torque since the enable may pass."""
        if self.share < 1.0:
            self.share = min(self.share + self._step, 1.0)
        elif self._regained < 1.0:
            self._regained = min(self._regained + self._step, 1.0)
        return self.share >= 1.0
