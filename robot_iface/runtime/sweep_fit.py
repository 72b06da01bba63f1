"""The fit and sign check after donning: small slow movements, one joint of every digit at a time.

Neighbouring digits move in opposite directions, so that exchanged channels show as a wrong sign. Whatever is
wrong lets go of the hand at once and ends the run with the reason.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from robot_iface.control import Goal
from robot_iface.errors import Refused
from robot_iface.runtime.sweep_fit_reading import FAILED, measure, verdict_of
from robot_iface.runtime.sweep_kernels import SET
from robot_iface.runtime.sweep_task import SweepTask
from robot_iface.runtime.task import Remark
from robot_iface.types import DIGITS, DeviceState, Float64, Plan

AMPLITUDE_RAD = float(np.deg2rad(4.0))
SPEED_RAD_S = float(np.deg2rad(5.0))
CHECK_MULTIPLE = 1.5
DIFFER_RAD = float(np.deg2rad(2.0))
"""Largest difference of the two position sensors: well below the 5 degrees at which power is cut."""
STRAY_RAD = float(np.deg2rad(2.0))
"""How far a joint may go against what is asked, or away from where it is held while stiffness rises."""
LAG_RAD = float(np.deg2rad(4.0))
_SHAKE_MULTIPLE = 1.5  # of what the free hand shakes, it may stray more
_SMOOTH_S = 0.2  # what a tremor makes of a joint's place is averaged out
_TAKE_OVER_S = 1.0
_NEAR_RAD = float(np.deg2rad(0.2))
_EVERY = 10
_LEGS = (1.0, -1.0, 0.0)


class FitCheck(SweepTask):
    """``Task`` of a plan whose sweep is of kind "fit".

    PhaseChanges carry "check" as phase and the group of joints as repetition. ``reason`` ends as "sweep", or
    as "fit: " and the sentence that says what is wrong.

    Args:
        plan: What to do.
        period_s: Control period.

    Raises:
        Refused: The plan's sweep is of another kind.
    """

    def __init__(self, plan: Plan, period_s: float) -> None:
        super().__init__(plan, period_s)
        if self._sweep.kind != "fit":
            raise Refused(
                "fit check", f"a sweep of kind {self._sweep.kind}", "of kind fit", "plan a fit check"
            )
        self._names = plan.joint_names
        self._recorded = plan.twin.stiffness_nm_rad
        self._bounds[2:4] = np.minimum(self._bounds[2:4], SPEED_RAD_S)
        self._groups = _groups(self._names)
        self._senses = np.array([1.0 - 2.0 * (_digit(name) % 2) for name in self._names])
        self._held_rad: Float64 = self._zeros
        self._centre_rad: Float64 = self._zeros
        self._from_rad: Float64 = self._zeros
        self._smooth_rad: Float64 = self._zeros
        self._shake_rad: Float64 = self._zeros
        self._free_ticks = 0
        self._asked_ways: Float64 = self._zeros
        self._leg = -1
        self._samples: list[tuple[Float64, Float64, Float64]] = []

    def begin(self, q_rad: Float64) -> None:
        """The hand is here; after a hold the check goes on with the next group."""
        self._smooth_rad, self._shake_rad = q_rad.copy(), self._zeros
        self._free_ticks = 0
        self._place(q_rad)
        self._rest()

    def step(self, state: DeviceState, load_share: float, active: bool) -> Goal:
        """What this tick asks for: see ``Task``."""
        self._take(state)
        self._smooth_rad = self._smooth_rad + (state.q_rad - self._smooth_rad) * (self._period_s / _SMOOTH_S)
        if self.done or not active:
            self._hold_here()
            return self._asked(0.0)
        self._lead(CHECK_MULTIPLE, held=self._leg < 0)
        wrong = self._wrong(state)
        if wrong:
            self._let_go(wrong)
        elif not self.paused:
            self._go_on()
        return self._asked(0.0)

    def reverse(self) -> None:
        """Leave this group out and go on."""
        self._rest()

    def advance(self) -> None:
        """The order of the check is fixed: nothing."""

    def trouble(self) -> None:
        """Pain, or a latched state, says that it does not fit."""
        if not self.done:
            self._let_go("the check was broken off, but must be made to its end: look at the hand and repeat")

    def reversed_on_load(self, q_rad: Float64) -> None:
        """A load that must be gone back on says that it does not fit."""
        self._place(q_rad)
        self.trouble()

    def _hold_here(self) -> None:
        """Follow without stiffness; from here the check will begin. How much the hand shakes is noted."""
        self._ticks = 0
        self._free_ticks += 1
        if self._free_ticks * self._period_s > 2.0 * _SMOOTH_S:
            self._shake_rad = np.maximum(self._shake_rad, np.abs(self._measured[0] - self._smooth_rad))
        self._free()
        low, high = self._bounds[0] + AMPLITUDE_RAD, self._bounds[1] - AMPLITUDE_RAD
        self._held_rad = np.minimum(np.maximum(self._smooth_rad, self._bounds[0]), self._bounds[1])
        self._centre_rad = np.minimum(np.maximum(self._held_rad, low), np.maximum(high, low))
        self._table[SET] = self._held_rad
        self._head_for(self._held_rad)

    def _rest(self) -> None:
        """Stiffness rises, or stays, where the hand is."""
        self._leg, self._ticks = -1, 0

    def _go_on(self) -> None:
        """Next group, leg or tick of a leg."""
        if self._leg < 0:
            if self._after(_TAKE_OVER_S):
                self._next_group()
            return
        if self._ticks % _EVERY == 0:
            self._samples.append((self._goal_now(), self._measured[0].copy(), self._measured[2].copy()))
        here = float(np.abs(self._goal - self._table[SET]).max()) < _NEAR_RAD
        if here or self._after(self._sweep.timeout_s):
            self._next_leg()

    def _goal_now(self) -> Float64:
        return self._table[SET].copy()

    @property
    def reference_rad(self) -> Float64:
        """Where the joints are led at this instant."""
        return self._table[SET].copy()

    def _next_group(self) -> None:
        if self.repetition + 1 == len(self._groups):
            self.reason = "sweep"
            self.phase, self.started_by = "done", ""
            return
        self.repetition += 1
        self._age_ticks = 0
        self.phase, self.started_by = "check", "robot"
        self._samples.clear()
        self._next_leg()

    def _next_leg(self) -> None:
        """The next leg of this group; after the last one, what it showed."""
        self._leg += 1
        self._ticks = 0
        if self._leg == len(_LEGS):
            self._judge()
            return
        moved = self._groups[self.repetition]
        goal = self._centre_rad + _LEGS[self._leg] * AMPLITUDE_RAD * self._senses
        self._from_rad = self._smooth_rad.copy()
        self._head_for(np.where(moved, goal, self._held_rad))
        self._asked_ways = np.where(moved, np.sign(self._goal - self._table[SET]), 0.0)

    def _judge(self) -> None:
        asked, q, tau = (np.array(rows) for rows in zip(*self._samples, strict=True))
        found = measure(asked, q, tau, self._period_s * _EVERY)
        found[:, ~self._groups[self.repetition]] = np.nan
        verdict = verdict_of(self._names, found, self._recorded)
        if verdict:
            self._let_go(verdict)
            return
        self._held_rad = np.where(self._groups[self.repetition], self._goal, self._held_rad)
        self._rest()

    def _wrong(self, state: DeviceState) -> str:
        """What cannot wait for the end of a group, empty if all is well."""
        apart = np.abs(state.q_rad - state.q_second_rad)
        shaken = _SHAKE_MULTIPLE * self._shake_rad
        against = (self._from_rad - state.q_rad) * self._asked_ways - shaken
        lag = np.abs(self._table[SET] - state.q_rad) - shaken
        rules = (
            (apart, DIFFER_RAD, "has sensors that differ by", "calibrate the device"),
            (against, STRAY_RAD, "goes the wrong way by", "check the sign of its sensor and motor"),
            (lag, STRAY_RAD if self._leg < 0 else LAG_RAD, "strays by", "check its sensor, motor and strap"),
        )
        for values, bound, text, remedy in rules:
            joint = int(np.argmax(values))
            if float(values[joint]) > bound:
                value = f"{np.rad2deg(values[joint]):.1f}°, bound {np.rad2deg(bound):.1f}°"
                return f"{self._names[joint]} {text} {value}: {remedy} and repeat"
        return ""

    def _let_go(self, why: str) -> None:
        """No stiffness from this tick on; the run ends."""
        self._place(self._measured[0])
        self._asked_ways = self._zeros
        joint = why.split(" ", 1)[0]
        self._remark = Remark("fit-failed", joint=joint if joint in self._names else "")
        self.reason = f"{FAILED}{why}"
        self.phase, self.started_by = "done", ""


def _digit(name: str) -> int:
    return DIGITS.index(name.split("_", 1)[0])


def _groups(names: tuple[str, ...]) -> list[NDArray[np.bool_]]:
    """Which joints move together: the first of every digit, then the second, and so on; masks (J,)."""
    digits = [_digit(name) for name in names]
    places = np.array([digits[:column].count(digit) for column, digit in enumerate(digits)])
    return [places == place for place in range(int(places.max()) + 1)]
