"""The guided sweep that measures today's range: alone first, then gently led on to the end.

In words, for each posture: the patient is asked to make it alone while the device only follows (active); the
device takes over there and goes on slowly until each joint is there or carries half of what it may (passive);
then it goes back to the relaxed hand (rest). The last rest ends the sweep.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from robot_iface.control import Goal
from robot_iface.errors import Refused
from robot_iface.runtime.orders import Patient
from robot_iface.runtime.sweep_kernels import SET
from robot_iface.runtime.sweep_task import FEEDBACK, SweepTask
from robot_iface.types import DeviceState, Float64, Plan

POSTURES: tuple[str, ...] = ("open", "tabletop", "hook", "fist")
"""Postures that a range sweep knows."""
LEADING_MULTIPLE = 2.0
SETTLE_S = 0.5
_TAKE_OVER_S = 1.2
_REACTION_S = 2.0  # before this, a hand that has not moved yet is not one that has arrived
_STILL_RAD_S = float(np.deg2rad(3.0))
_LED_RAD_S = float(np.deg2rad(0.6))
_NEAR_RAD = float(np.deg2rad(2.0))
_CUE_STEP_S = 0.01


class GuidedSweep(SweepTask):
    """``Task`` of a plan whose sweep is of kind "range".

    PhaseChanges carry the posture's name as phase and its index as repetition, ``started_by`` "patient" in
    the active part and "robot" in the passive one; "rest" on the way back.

    Args:
        plan: What to do.
        patient: The patient's side: cued in the active parts.
        period_s: Control period.

    Raises:
        Refused: The plan's sweep is of another kind, or a posture has an unknown name.
    """

    def __init__(self, plan: Plan, patient: Patient, period_s: float) -> None:
        super().__init__(plan, period_s)
        unknown = [name for name in self._sweep.postures if name not in POSTURES]
        if self._sweep.kind != "range" or unknown or not self._sweep.postures:
            value = ", ".join(unknown) or f"of kind {self._sweep.kind} with {len(self._sweep.postures)}"
            raise Refused("sweep postures", value, "one or more of " + ", ".join(POSTURES), "choose these")
        self._patient = patient
        self._rest_rad: Float64 = self._zeros
        self._from_rad: Float64 = self._zeros
        self._quiet_ticks = 0
        self._way_s = 1.0
        self._again = self._repeated = False
        self._stages: dict[str, Callable[[], float]] = {
            "settle": self._settle,
            "active": self._active,
            "take-over": self._take_over,
            "passive": self._passive,
            "rest": self._back,
            "done": lambda: 0.0,
        }
        self._stage = "settle"

    def begin(self, q_rad: Float64) -> None:
        """The hand is here: relaxed before the first posture; after a hold, it goes back to rest first."""
        self._place(q_rad)
        if self.repetition < 0:
            self._rest_rad = q_rad.copy()
            self._head_for(q_rad)
        elif self._stage != "done":
            self._go_back()

    def step(self, state: DeviceState, load_share: float, active: bool) -> Goal:
        """What this tick asks for: see ``Task``."""
        if not active:
            self._take_still(state)
            return self._asked(0.0)
        self._take(state)
        feedback = self._stages[self._stage]()
        return self._asked(feedback)

    def reverse(self) -> None:
        """Go back to the relaxed hand, and then on to the next posture."""
        if self.repetition >= 0 and not self.done:
            self._go_back()

    def advance(self) -> None:
        """On to the next part of this posture, or from its rest to the next posture."""
        if self._stage == "active":
            self._hand_over()
        elif self._stage in ("take-over", "passive"):
            self._go_back()
        elif self._stage == "rest":
            self._next()

    def trouble(self) -> None:
        """Pain, or a latched state: this posture is not tried again."""
        self._patient.relax()

    def reversed_on_load(self, q_rad: Float64) -> None:
        """The supervisor has gone back on a load: back to rest, and the posture is led to once more."""
        self._place(q_rad)
        self._again = not self._repeated
        self.reverse()

    def _take_still(self, state: DeviceState) -> None:
        """Follow the hand without stiffness until requests pass."""
        self._take(state)
        self._ticks = 0
        self._free()

    def _enter(self, stage: str, phase: str, starter: str) -> None:
        self._stage, self.phase, self.started_by = stage, phase, starter
        self._ticks = self._quiet_ticks = 0

    def _settle(self) -> float:
        """The relaxed hand is measured."""
        self._free()
        if self._after(SETTLE_S):
            self._rest_rad = self._measured[0].copy()
            self._next()
        return 0.0

    def _next(self) -> None:
        """The next posture, this one again after a reversal, or the end."""
        if not self._again and self.repetition + 1 == len(self._sweep.postures):
            self.reason = "sweep"
            self._enter("done", "done", "")
            return
        self.repetition += 0 if self._again else 1
        self._repeated, self._again = self._again, False
        self._age_ticks = 0
        goal = self._sweep.goals_rad[self.repetition]
        self._from_rad = self._measured[0].copy()
        self._table[SET] = self._from_rad
        self._head_for(goal)
        if self._sweep.active and not self._repeated:
            self._cue()
            self._enter("active", self._posture, "patient")
        else:
            self._enter("take-over", self._posture, "robot")

    @property
    def _posture(self) -> str:
        return self._sweep.postures[self.repetition]

    def _cue(self) -> None:
        """Ask the patient for the posture, along a straight way at a leisurely speed."""
        way = self._goal - self._from_rad
        self._way_s = max(float(np.abs(way).max()) / self._sweep.speed_rad_s, 1.0)
        shares = np.linspace(0.0, 1.0, round(self._way_s / _CUE_STEP_S) + 1)
        self._patient.cue(self._from_rad + shares[:, None] * way, _CUE_STEP_S, 1.0)

    def _active(self) -> float:
        """The patient moves; ends with the hand still for a while, or when time is up."""
        speed = self._free()
        if self._ticks % 10 == 0:
            way = self._goal - self._from_rad
            share = float(way @ (self._measured[0] - self._from_rad)) / (float(way @ way) + 1e-12)
            self._patient.progress(min(max(share, 0.0), 1.0) * self._way_s)
        if self._rests(speed < _STILL_RAD_S and self._after(_REACTION_S)):
            self._hand_over()
        return FEEDBACK

    def _hand_over(self) -> None:
        """The device takes the hand where the patient has brought it."""
        self._place(self._measured[0])
        self._head_for(self._goal)
        self._enter("take-over", self._posture, "robot")

    def _take_over(self) -> float:
        """Stiffness rises where the hand is; only then may the patient let go."""
        self._lead(LEADING_MULTIPLE, held=True)
        if self._after(_TAKE_OVER_S):
            self._patient.relax()
            self._enter("passive", self._posture, "robot")
        return 0.0

    def _passive(self) -> float:
        """On to the goal, as far as the load allows; ends once everything rests."""
        led, hand = self._lead(LEADING_MULTIPLE)
        if self._rests(led < _LED_RAD_S and hand < _STILL_RAD_S and self._after(_REACTION_S)):
            self._go_back()
        return 0.0

    def _go_back(self) -> None:
        self._patient.relax()
        self._head_for(self._rest_rad)
        self._enter("rest", "rest", "robot")

    def _back(self) -> float:
        """Back to the relaxed hand, then without stiffness."""
        near = float(np.abs(self._goal - self._table[SET]).max()) < _NEAR_RAD
        led, hand = self._lead(LEADING_MULTIPLE)
        arrived = near or (led < _LED_RAD_S and self._after(_REACTION_S))
        if self._rests(arrived and hand < _STILL_RAD_S):
            self._next()
        return 0.0

    def _rests(self, quiet: bool) -> bool:
        """Whether it has been quiet for the dwell, or the part has lasted too long."""
        self._quiet_ticks = self._quiet_ticks + 1 if quiet and not self.paused else 0
        dwelt = self._quiet_ticks * self._period_s >= self._sweep.dwell_s
        return dwelt or self._after(self._sweep.timeout_s)
