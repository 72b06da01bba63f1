"""How far a patient came by own effort in one repetition."""

from __future__ import annotations

import numpy as np

from robot_iface.control.assist import DEAD_BAND_RAD
from robot_iface.types import DeviceState, Float64, Plan

_EVERY = 10
"""One in so many ticks is looked at."""
REACHED_SHARE = 0.75
"""Help that is given as needed leaves a patient this far behind although nothing is amiss."""
_BEHIND_RAD = 2.0 * DEAD_BAND_RAD


class Attempt:
    """Follows the joint that the exercise moves most.

    Where the robot only measures or resists, the range counts. Where it helps, the range is always reached:
    what counts there is how far the hand leads the robot, which the robot's help cannot raise. (Motion
    without its push counts nothing: it falls when help is taken back from a patient who is not tired.)

    Args:
        plan: Limits and mode.
        span_rad: Range of each joint in the movement, (J,).
    """

    def __init__(self, plan: Plan, span_rad: Float64) -> None:
        self._joint = int(np.argmax(span_rad))
        self.helped = plan.prescription.mode in ("passive", "assistive")
        """Whether the robot takes the hand along."""
        self._ticks = 0
        self.begin()

    def begin(self) -> None:
        """A new repetition."""
        self._low = self._target_low = np.inf
        self._high = self._target_high = -np.inf
        self._last: tuple[float, float] | None = None
        self._ahead = self._behind = 0.0
        self._count = 0

    def watch(self, state: DeviceState, target_rad: Float64) -> None:
        """Take a tick of the movement, with the target posture, (J,)."""
        self._ticks += 1
        if self._ticks % _EVERY:
            return
        joint = self._joint
        q, target = float(state.q_rad[joint]), float(target_rad[joint])
        self._low, self._high = min(self._low, q), max(self._high, q)
        self._target_low, self._target_high = min(self._target_low, target), max(self._target_high, target)
        if self._last is not None:
            way = target - self._last[1]
            sign = (way > 0.0) - (way < 0.0)
            if sign:
                self._ahead += (q - target) * sign
                self._behind += max((target - q) * sign, 0.0)
                self._count += 1
        self._last = (q, target)

    def reached(self, started_by: str) -> float:
        """Own effort as a share of the range asked for: the range reached; where helped, the mean lead."""
        if not self.helped:
            return self._share()
        if started_by != "patient":
            return 0.0
        asked = self._target_high - self._target_low
        return max(self._ahead / (self._count * asked), 0.0) if self._count and asked > 0.0 else 0.0

    def succeeded(self, started_by: str) -> bool:
        """Whether the patient started it and reached the target, where helped without falling behind."""
        behind = self.helped and self._behind > _BEHIND_RAD * max(self._count, 1)
        return started_by == "patient" and self._share() >= REACHED_SHARE and not behind

    def _share(self) -> float:
        asked = self._target_high - self._target_low
        return min((self._high - self._low) / asked, 1.0) if asked > 0.0 else 0.0
