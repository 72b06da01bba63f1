"""How much of a movement's range a repetition is allowed: the warm-up, and what reversals take off."""

from __future__ import annotations

import numpy as np

from robot_iface.motion import Narrowing, QuinticPath, narrowed, unchanged
from robot_iface.motion.limits import hulls_exceeded
from robot_iface.types import Float64, Plan

WARM_UP_RAD = float(np.deg2rad(10.0))
WARM_UP_STEP_RAD = float(np.deg2rad(2.0))
CUT_RAD = float(np.deg2rad(5.0))
_SAMPLES = 400
_ROUNDING_RAD = 1e-6


class Allowance:
    """The range of one exercise from repetition to repetition: narrower than the path, never wider or faster.

    Args:
        path: The whole movement.
        plan: Limits of today and the length of the warm-up.
    """

    def __init__(self, path: QuinticPath, plan: Plan) -> None:
        self._plan = plan
        self._low_rad, self._high_rad = path.span_rad()
        self._cut_low_rad: Float64 = np.zeros(self._low_rad.size)
        self._cut_high_rad: Float64 = np.zeros(self._low_rad.size)
        self._postures: Float64 = path.sample(np.linspace(0.0, path.duration_s, _SAMPLES))

    def cut(self, direction: Float64) -> None:
        """Take 5 degrees off the end of the range towards which each joint was moved.

        Args:
            direction: Positive for joints that were flexed, negative for extended ones, (J,).
        """
        self._cut_high_rad += CUT_RAD * (direction > 0.0)
        self._cut_low_rad += CUT_RAD * (direction < 0.0)

    def for_repetition(self, repetition: int) -> Narrowing:
        """What is allowed in a repetition, counted from 0."""
        floor, ceiling = self._low_rad + self._cut_low_rad, self._high_rad - self._cut_high_rad
        if repetition < self._plan.prescription.warm_up_repetitions:
            margin = max(WARM_UP_RAD - repetition * WARM_UP_STEP_RAD, 0.0)
            floor = np.maximum(floor, self._plan.limits.q_min_rad + margin)
            ceiling = np.minimum(ceiling, self._plan.limits.q_max_rad - margin)
        if bool((floor <= self._low_rad).all() and (ceiling >= self._high_rad).all()):
            return unchanged(floor.size)
        return self._within_hulls(narrowed(self._low_rad, self._high_rad, floor, ceiling))

    def _within_hulls(self, wanted: Narrowing) -> Narrowing:
        """The same, or where joints that are narrowed apart would leave a common range, all joints together.

        Postures between two postures of the path never leave a convex set that holds the path.
        """
        plan = self._plan
        hulls, names = plan.limits.hulls, plan.joint_names
        if not hulls:
            return wanted
        whole = hulls_exceeded(self._postures, names, hulls)
        apart = hulls_exceeded(wanted.apply(self._postures), names, hulls)
        if bool((apart <= np.maximum(whole, 0.0) + _ROUNDING_RAD).all()):
            return wanted
        scale = np.full(wanted.scale.size, float(wanted.scale.min()))
        middle = self._postures.mean(axis=0)
        return Narrowing(np.stack((scale, (1.0 - scale) * middle)))
