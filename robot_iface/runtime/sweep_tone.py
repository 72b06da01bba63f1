"""The tone test: the relaxed fingers are stretched at several speeds, and what they oppose is measured.

In words, for each stretch: the device folds the fingers slowly to where it begins and waits until they rest,
then opens them at the speed of this stretch, as far as the load allows. At the end it goes back to the
relaxed hand. A spastic muscle opposes the more the faster it is stretched; a short one does not care.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from robot_iface.control import Goal
from robot_iface.errors import Refused
from robot_iface.runtime.sweep_kernels import SET
from robot_iface.runtime.sweep_task import SweepTask
from robot_iface.runtime.sweep_tone_kernel import stretch
from robot_iface.types import DeviceState, Float64, Plan
from robot_iface.types.plan import FASTEST_STRETCH_RAD_S

STRETCH = "stretch"
FOLD = "fold"
STIFF_MULTIPLE = 3.0
"""A firm hold, so that the fingers come near the speed that is asked."""
STOP_SHARE = 0.85
"""Share of the interaction limit at which a slow stretch ends: a moment may load more than a hold."""
STOP_SHARE_FAST = 0.4
"""The same of the fastest stretch: until it has come to rest, the load rises on."""
_GIVE_UP_S = 1.5
_HOLD_S = 0.4
_ACCELERATION_RAD_S2 = 15.0  # 90 deg/s is reached within 5 degrees
_TAKE_OVER_S = 1.2
_NEAR_RAD = float(np.deg2rad(2.0))
_STILL_RAD_S = float(np.deg2rad(3.0))


class ToneTest(SweepTask):
    """``Task`` of a plan whose sweep is of kind "tone".

    PhaseChanges carry "fold" before and "stretch" during each stretch with its index as repetition, "rest" on
    the way back, and ``started_by`` "robot".

    Args:
        plan: What to do.
        period_s: Control period.

    Raises:
        Refused: The plan's sweep is of another kind, or holds no stretch.
    """

    def __init__(self, plan: Plan, period_s: float) -> None:
        super().__init__(plan, period_s)
        if self._sweep.kind != "tone" or not self._sweep.postures:
            value = f"of kind {self._sweep.kind} with {len(self._sweep.postures)} stretches"
            raise Refused("tone test", value, "of kind tone with stretches", "plan a tone test")
        limits = plan.limits
        self._fast = self._bounds.copy()
        self._tau_nm = limits.tau_interaction_nm
        self._allowed = np.stack((limits.flexion_speed_rad_s, limits.extension_speed_rad_s))
        self._acceleration = np.full(len(self._sweep.joint_names), _ACCELERATION_RAD_S2)
        self._start: Float64 = np.array(self._sweep.start_rad)
        self._rest_rad: Float64 = self._zeros
        self._loaded: Float64 = np.zeros(len(self._sweep.joint_names))
        self._stages: dict[str, Callable[[], None]] = {
            "settle": self._settle,
            "take-over": self._take_over,
            "fold": self._fold,
            "stretch": self._stretch,
            "hold": self._hold,
            "rest": self._back,
            "done": lambda: None,
        }
        self._stage = "settle"
        self._stretch_at(0.0)

    def begin(self, q_rad: Float64) -> None:
        """The hand is here: relaxed before the first stretch; after a hold, it goes back to rest."""
        self._place(q_rad)
        if self.repetition < 0:
            self._rest_rad = q_rad.copy()
            self._head_for(q_rad)
        elif self._stage != "done":
            self._go_back()

    def step(self, state: DeviceState, load_share: float, active: bool) -> Goal:
        """What this tick asks for: see ``Task``."""
        self._take(state)
        if not active:
            self._ticks = 0
            self._free()
        else:
            self._stages[self._stage]()
        return self._asked(0.0)

    def reverse(self) -> None:
        """Leave the rest of the test out and go back to the relaxed hand."""
        if self.repetition >= 0 and not self.done:
            self._go_back()

    def advance(self) -> None:
        """End this stretch and go on with the next."""
        if self._stage in ("stretch", "hold"):
            self._next()

    def trouble(self) -> None:
        """Pain, or a latched state, ends the test."""
        self.reverse()

    def reversed_on_load(self, q_rad: Float64) -> None:
        """The supervisor has gone back on a load: this stretch is over."""
        self._place(q_rad)
        self.reverse()

    def _enter(self, stage: str, phase: str) -> None:
        self._stage, self.phase, self.started_by = stage, phase, "robot"
        self._ticks = 0

    def _settle(self) -> None:
        """The relaxed hand is taken over where it is."""
        self._free()
        if self._after(_HOLD_S):
            self._rest_rad = self._measured[0].copy()
            self._place(self._rest_rad)
            self._head_for(self._rest_rad)
            self._enter("take-over", FOLD)

    def _take_over(self) -> None:
        self._lead(STIFF_MULTIPLE, held=True)
        if self._after(_TAKE_OVER_S):
            self._next()

    def _next(self) -> None:
        """Fold for the next stretch, or go back after the last."""
        if self.repetition + 1 == len(self._sweep.postures):
            self._go_back()
            return
        self.repetition += 1
        self._age_ticks = 0
        self._head_for(self._start)
        self._enter("fold", FOLD)

    def _fold(self) -> None:
        """Slowly to where the stretch begins; it begins once the hand has rested there."""
        near = float(np.abs(self._goal - self._table[SET]).max()) < _NEAR_RAD
        led, _ = self._lead(STIFF_MULTIPLE)
        rests = near or (led < _STILL_RAD_S and self._after(_GIVE_UP_S))
        if not rests:
            self._age_ticks = 0
            return
        if self._age_ticks * self._period_s >= self._sweep.dwell_s and not self.paused:
            self._head_for(self._sweep.goals_rad[self.repetition])
            self._loaded[:] = 0.0
            hurry = min(self._sweep.stretch_rad_s[self.repetition] / FASTEST_STRETCH_RAD_S, 1.0)
            self._fast[4] = (STOP_SHARE + (STOP_SHARE_FAST - STOP_SHARE) * hurry) * self._tau_nm
            self._enter("stretch", STRETCH)

    def _stretch(self) -> None:
        """At the speed of this stretch, until every joint is there or carries what it may."""
        speed = 0.0 if self.paused else self._pace * self._sweep.stretch_rad_s[self.repetition]
        open_joints = self._stretch_at(speed)
        if open_joints == 0 or self._after(self._sweep.timeout_s):
            self._enter("hold", STRETCH)

    def _stretch_at(self, speed: float) -> int:
        """One tick of a stretch; returns how many joints are still on their way."""
        wanted = np.minimum(speed, self._allowed)
        return stretch(
            *(self._table, self._measured, self._goal, self._fast),
            *(wanted, self._acceleration, self._loaded, self._period_s),
        )

    def _hold(self) -> None:
        self._lead(STIFF_MULTIPLE, held=True)
        if self._after(_HOLD_S):
            self._next()

    def _go_back(self) -> None:
        self._head_for(self._rest_rad)
        self._enter("rest", "rest")

    def _back(self) -> None:
        """Back to the relaxed hand; that ends the test."""
        near = float(np.abs(self._goal - self._table[SET]).max()) < _NEAR_RAD
        led, hand = self._lead(STIFF_MULTIPLE)
        rests = (near and hand < _STILL_RAD_S) or (led < _STILL_RAD_S and self._after(_GIVE_UP_S))
        if (rests and self._after(_HOLD_S)) or self._after(self._sweep.timeout_s):
            self.reason = "sweep"
            self.phase, self.started_by, self._stage = "done", "", "done"
