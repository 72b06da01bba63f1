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
PUSH_SHARE = 0.1
"""Motion counts as own while the robot pushes with it by less than this share of the interaction limit."""


class Attempt:
    """Follows the joint that the exercise moves most.

    Where the robot helps, only motion without its push counts; where it only measures or resists, all does.

    Args:
        plan: Limits and mode.
        span_rad: Range of each joint in the movement, (J,).
    """

    def __init__(self, plan: Plan, span_rad: Float64) -> None:
        self._joint = int(np.argmax(span_rad))
        self._helped = plan.prescription.mode in ("passive", "assistive")
        self._push_nm = PUSH_SHARE * float(plan.limits.tau_interaction_nm[self._joint])
        self._ticks = 0
        self.begin()

    def begin(self) -> None:
        """A new repetition."""
        self._low = self._target_low = np.inf
        self._high = self._target_high = -np.inf
        self._last: tuple[float, float] | None = None
        self._travel = self._own = self._behind = 0.0
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
            self._travel += abs(way)
            if float(state.tau_interaction_nm[joint]) * sign < self._push_nm:
                self._own += max((q - self._last[0]) * sign, 0.0)
            if sign:
                self._behind += max((target - q) * sign, 0.0)
                self._count += 1
        self._last = (q, target)

    def reached(self) -> float:
        """Range reached by own effort, as a share of what was asked for; at most 1."""
        if self._helped:
            return min(self._own / self._travel, 1.0) if self._travel > 0.0 else 0.0
        return self._share()

    def succeeded(self, started_by: str) -> bool:
        """Whether the patient started it and reached the target, where helped without falling behind."""
        behind = self._helped and self._behind > _BEHIND_RAD * max(self._count, 1)
        return started_by == "patient" and self._share() >= REACHED_SHARE and not behind

    def _share(self) -> float:
        asked = self._target_high - self._target_low
        return min((self._high - self._low) / asked, 1.0) if asked > 0.0 else 0.0
