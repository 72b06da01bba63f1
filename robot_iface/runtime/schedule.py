"""What follows a repetition: another one, a rest, a look at the skin, or the end."""

from __future__ import annotations

from dataclasses import dataclass

from robot_iface.runtime.attempt import Attempt
from robot_iface.runtime.dose import Dose
from robot_iface.runtime.fatigue import Fatigue
from robot_iface.runtime.movement import Movement
from robot_iface.runtime.reversals import Reversals
from robot_iface.types import DeviceState, Float64, Plan


@dataclass(frozen=True, slots=True)
class Next:
    """What comes next.

    Attributes:
        phase: Phase to enter.
        reason: Why the run ends, where it does.
        remark: What is recorded of it.
    """

    phase: str
    reason: str = ""
    remark: str = ""


class Schedule:
    """Counts of one run and the rules over them.

    Args:
        plan: What is ordered.
        movement: What is played.
        return_s: Longest way back.
        period_s: Control period.
    """

    def __init__(self, plan: Plan, movement: Movement, return_s: float, period_s: float) -> None:
        self._ordered = plan.prescription
        self._own = plan.prescription.mode != "passive"
        self._attempt = Attempt(plan, movement.span_rad)
        self._fatigue = Fatigue(helped=self._attempt.helped)
        self._proposed = False
        self.dose = Dose(plan.prescription, movement.duration_s, return_s, period_s)
        """How long things have lasted."""
        self.reversals = Reversals()
        """Repetitions in which the load reversed the motion."""

    def set_off(self) -> None:
        """A repetition's movement begins."""
        self._attempt.begin()

    def watch(self, state: DeviceState, target_rad: Float64) -> None:
        """Take a tick of the movement, with the target posture, (J,)."""
        if self._own:
            self._attempt.watch(state, target_rad)

    def after_return(self, repetition: int, started_by: str) -> Next:
        """What follows when the hand is back; ``repetition`` counts from 0."""
        attempt = self._attempt
        tired = self._own and self._fatigue.note(
            attempt.reached(started_by), succeeded=attempt.succeeded(started_by)
        )
        if repetition + 1 >= self._ordered.repetitions:
            return Next("done", "repetitions")
        if self.dose.minutes_over:
            return Next("done", "minutes")
        if not tired:
            return Next("rest")
        if self._proposed:
            return Next("done", "fatigue", "fatigue")
        self._proposed = True
        self._fatigue.rested()
        return Next("rest-proposed", "", "fatigue")

    def after_rest(self) -> Next:
        """What follows a rest."""
        return Next("skin-check", "", "skin-check") if self.dose.skin_check_due else Next("ramp")
