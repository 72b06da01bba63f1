"""How long things have lasted: repetition, run, motion since the skin was looked at."""

from __future__ import annotations

from robot_iface.types import Prescription

_MARGIN_S = 10.0


class Dose:
    """Counts ticks; pauses and inserted rests are left out of repetition and motion.

    Args:
        ordered: What the therapist ordered.
        path_s: Length of the path.
        return_s: Longest way back.
        period_s: Control period.
    """

    def __init__(self, ordered: Prescription, path_s: float, return_s: float, period_s: float) -> None:
        self._ordered, self._path_s, self._period_s = ordered, path_s, period_s
        self._waits_s = ordered.ramp_s + ordered.cue_timeout_s + ordered.hold_s + ordered.rest_s + return_s
        self._run = self._motion = self._repetition = 0
        self._tick_ns = round(period_s * 1e9)
        self.timeout_ns = 0
        """How long a repetition may take: twice what it should at the slowest speed, and ten seconds."""
        self.slowed_to(ordered.speed)

    @property
    def repetition_ns(self) -> int:
        """Since the repetition began."""
        return self._repetition * self._tick_ns

    @property
    def minutes_over(self) -> bool:
        """Whether no new repetition may begin."""
        return 0.0 < self._ordered.minutes * 60.0 <= self._run * self._period_s

    @property
    def skin_check_due(self) -> bool:
        """Whether somebody must look at the skin now."""
        return 0.0 < self._ordered.skin_check_s <= self._motion * self._period_s

    def tick(self, *, moving: bool, repeating: bool) -> None:
        """Count one tick.

        Args:
            moving: Neither paused nor in an inserted rest.
            repeating: Moving, within a repetition.
        """
        self._run += 1
        self._motion += moving
        self._repetition += repeating

    def slowed_to(self, speed: float) -> None:
        """The slowest speed that has been asked for so far."""
        self.timeout_ns = round((2.0 * (self._waits_s + self._path_s / speed) + _MARGIN_S) * 1e9)

    def next_repetition(self) -> None:
        """Count a repetition anew."""
        self._repetition = 0

    def skin_checked(self) -> None:
        """Count motion anew."""
        self._motion = 0
