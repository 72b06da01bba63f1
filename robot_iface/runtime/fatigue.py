"""When a patient tires: what is reached falls from five repetitions to the next five."""

from __future__ import annotations

from collections import deque

WINDOW = 5
RANGE_SHARE = 0.8
SUCCESS_SHARE = 0.5
LEAST_SHARE = 0.03
"""Effort that never was more than this share of the movement says nothing when it falls."""
REST_S = 60.0
"""Rest that is inserted when it shows first; when it shows again, the run ends."""


class Fatigue:
    """Compares the last five repetitions with the best five before them.

    Fatigue is a fall: what the patient reaches by own effort below 80 % of the best five, or success below
    50 % where five before were at least that good. A hand that never could is weak, not tired.

    Args:
        helped: Whether the robot takes the hand along. Then less effort alone is no fatigue: who slackens
            because the robot does it well still succeeds.
    """

    def __init__(self, *, helped: bool) -> None:
        self._helped = helped
        self._ranges: deque[float] = deque(maxlen=WINDOW)
        self._successes: deque[bool] = deque(maxlen=WINDOW)
        self._best_range = 0.0
        self._best_success = 0.0

    def note(self, reached: float, *, succeeded: bool) -> bool:
        """Take one repetition.

        Args:
            reached: What was reached by own effort, as a share of what was asked for.
            succeeded: Whether the patient started it and reached the target without falling behind.

        Returns:
            Whether the last five show fatigue.
        """
        self._ranges.append(reached)
        self._successes.append(succeeded)
        if len(self._ranges) < WINDOW:
            return False
        mean, success = sum(self._ranges) / WINDOW, sum(self._successes) / WINDOW
        fallen = mean < RANGE_SHARE * self._best_range and self._best_range >= LEAST_SHARE
        failing = success < SUCCESS_SHARE
        tired = fallen and (failing or not self._helped)
        tired = tired or (failing and self._best_success >= SUCCESS_SHARE)
        self._best_range = max(self._best_range, mean)
        self._best_success = max(self._best_success, success)
        return tired

    def rested(self) -> None:
        """Count five new repetitions; the best ones stay what they are measured by."""
        self._ranges.clear()
        self._successes.clear()
