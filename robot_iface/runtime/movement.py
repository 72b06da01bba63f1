"""The movement of an exercise as it is played now: path, coordinate, and today's share of its range."""

from __future__ import annotations

import numpy as np

from robot_iface.errors import Refused
from robot_iface.motion import PathPlayer, PathState, QuinticPath, Setpoint
from robot_iface.runtime.allowance import Allowance
from robot_iface.runtime.heading import cued_direction, headings
from robot_iface.types import Float64, Plan

CUE_STEP_S = 0.005


class Movement:
    """A path that is played repetition by repetition, each within its own range.

    Args:
        plan: What to play.
        period_s: Control period.

    Raises:
        Refused: There is no path, or it cannot be played.
    """

    def __init__(self, plan: Plan, period_s: float) -> None:
        if plan.path is None:
            raise Refused("exercise", "without a path", "with a path", "plan a take")
        self._whole = self._path = QuinticPath(plan.path)
        self.duration_s = self._whole.duration_s
        back = self._whole.fastest_back(plan.limits)
        self.player = PathPlayer(self.duration_s, period_s, plan.prescription.speed, back_speed=back)
        self._allowance = Allowance(self._whole, plan)
        self._table = self._whole.sample(np.arange(0.0, self.duration_s + CUE_STEP_S, CUE_STEP_S))
        self.headings_rad: Float64 = headings(self._table)
        """Where the whole path is going, CUE_STEP_S apart, (M, J)."""
        self.cued_direction: Float64 = cued_direction(self._whole)
        """Displacement at the beginning of the path, (J,)."""
        low, high = self._whole.span_rad()
        self.span_rad: Float64 = high - low
        """Range of each joint in the whole movement, (J,)."""
        self.rate_rad_s: Float64 = np.zeros(low.size)
        """Speeds of the last set-point of the path, (J,)."""
        self._still = np.zeros(low.size)
        self.prepare(0)

    @property
    def state(self) -> PathState:
        """Where the path stands."""
        return self.player.state

    @property
    def cue_table(self) -> Float64:
        """Postures of this repetition, CUE_STEP_S apart, (M, J)."""
        return self._narrowing.apply(self._table)

    def prepare(self, repetition: int) -> None:
        """Take the range of a repetition; only while the path is not being played."""
        self._narrowing = self._allowance.for_repetition(repetition)
        self._path = self._whole.within(self._narrowing)
        self._headings = self.headings_rad * self._narrowing.scale
        self.start = Setpoint(self._path.start_rad(), self._still, self._still)
        self.end = Setpoint(self._path.end_rad(), self._still, self._still)
        self._here = self.start

    def step(self) -> Setpoint:
        """The set-point of the next tick."""
        state = self.player.step()
        self._here = here = self._path.evaluate(state.s, state.s_dot, state.s_ddot)
        self.rate_rad_s = here.dq_rad_s
        return here

    @property
    def here_rad(self) -> Float64:
        """Posture at the path coordinate, (J,)."""
        return self._here.q_rad

    def heading(self) -> Float64:
        """Where the path is going at its coordinate, (J,)."""
        return self._headings[min(int(self.player.state.s / CUE_STEP_S), len(self._headings) - 1)]

    def give_up(self) -> None:
        """Stand at the beginning: the hand has been led away from the path."""
        self.player.abandon()
        self._here = self.start

    def cut(self) -> None:
        """Take range off the ends towards which the joints were moving."""
        self._allowance.cut(np.where(np.abs(self.rate_rad_s) > 1e-6, self.rate_rad_s, 0.0))
