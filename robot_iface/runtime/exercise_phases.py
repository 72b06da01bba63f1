"""What the run is doing: approach, ramp, cue, move, hold, return, rest, and again.

In words: the hand is brought to the start of the path (approach), stiffness rises to what was prescribed or
to what lets a weak start be seen (ramp), where the patient begins, he is cued and waited for (cue), the path
is played (move), its end is held (hold), the hand goes back to the start (return) and rests (rest); after the
last repetition the run is done. A tired patient is given a longer rest (rest-proposed); where the skin must
be looked at, the run waits for a person (skin-check).
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable

from robot_iface.control import Start, StartTrigger, require_mode
from robot_iface.motion import Setpoint, Transfer
from robot_iface.runtime.drift import DRIFT_RAD, NeutralDrift
from robot_iface.runtime.fatigue import REST_S
from robot_iface.runtime.guidance import APPROACH_MULTIPLE, Guidance
from robot_iface.runtime.movement import CUE_STEP_S, Movement
from robot_iface.runtime.orders import Patient
from robot_iface.runtime.schedule import Next, Schedule
from robot_iface.runtime.task import Remark
from robot_iface.types import DeviceState, Float64, Plan

SKIN_CHECK_WAIT_S = 300.0
"""A skin check that nobody confirms ends the run after this time."""

PROBE_S = 2.0
"""Rest without stiffness in which a hand whose fit is in doubt shows where it carries no load."""


class ExercisePhases:
    """The phases and what leads from each to the next.

    Args:
        plan: What to do.
        patient: The patient's side.
        period_s: Control period.

    Raises:
        Refused: There is no such mode, no path, or it cannot be played.
    """

    def __init__(self, plan: Plan, patient: Patient, period_s: float) -> None:
        ordered = plan.prescription
        require_mode(ordered.mode)
        self._plan, self._ordered, self._patient, self._period_s = plan, ordered, patient, period_s
        self._movement = movement = Movement(plan, period_s)
        self._guidance = Guidance(plan, movement, period_s)
        self._waits = ordered.mode != "passive"
        self._trigger = StartTrigger(movement.cued_direction, period_s, ordered.cue_timeout_s)
        self._back = self._lead(movement.end.q_rad)
        self._schedule = Schedule(plan, movement, self._back.seconds, period_s)
        self._dose = self._schedule.dose
        self._drift = NeutralDrift(len(plan.joint_names), period_s)
        self._way: Transfer | None = None
        self._ticks = 0
        self._probes = False
        self._remarks: deque[Remark] = deque()
        self._steps: dict[str, Callable[[DeviceState, float], Setpoint]] = {
            "approach": self._approach,
            "ramp": self._ramp,
            "cue": self._cue,
            "move": self._move,
            "hold": self._hold,
            "return": self._return,
            "rest": self._rest,
            "rest-proposed": self._rest_longer,
            "skin-check": self._await_skin_check,
            "done": self._stay,
        }
        self.phase = "approach"
        self.repetition = -1
        self.started_by = ""
        self.reason = ""

    def _enter(self, phase: str) -> None:
        self.phase, self._ticks = phase, 0

    def _after(self, seconds: float) -> bool:
        """Whether the phase has lasted this long, unless it is paused."""
        return self._ticks * self._period_s >= seconds and not self._movement.player.paused

    def _lead(self, q_rad: Float64) -> Transfer:
        """The straight way from a posture, (J,), to the start of the path."""
        return Transfer(q_rad, self._movement.start.q_rad, self._plan.limits, self._period_s)

    def _approach(self, state: DeviceState, load_share: float) -> Setpoint:
        self._next_repetition()
        return self._movement.start

    def _ramp(self, state: DeviceState, load_share: float) -> Setpoint:
        if self._after(self._ordered.ramp_s):
            if not self._waits:
                self._set_off("robot")
            elif self._trigger.update(state.q_rad) == Start.CUED:
                self._judge_the_fit()
                self._patient.cue(self._movement.cue_table, CUE_STEP_S, self._ordered.speed)
                self._enter("cue")
        return self._movement.start

    def _cue(self, state: DeviceState, load_share: float) -> Setpoint:
        start = self._trigger.update(state.q_rad)
        if start >= Start.PATIENT and not self._movement.player.paused:
            self._set_off("patient" if start == Start.PATIENT else "robot")
        return self._movement.start

    def _set_off(self, starter: str) -> None:
        self.started_by = starter
        self._schedule.set_off()
        self._enter("move")

    def _move(self, state: DeviceState, load_share: float) -> Setpoint:
        setpoint = self._movement.step()
        path = self._movement.state
        if path.s_dot > 0.0:
            self._guidance.observe(setpoint, state, load_share)
            if self._waits:
                self._patient.progress(path.s)
                self._schedule.watch(state, setpoint.q_rad)
        if path.at_end:
            self._enter("hold")
        return setpoint

    def _hold(self, state: DeviceState, load_share: float) -> Setpoint:
        end = self._movement.end
        if self._guidance.free:
            self._schedule.watch(state, end.q_rad)
        if self._after(self._ordered.hold_s):
            self._go_back(state.q_rad)
        return end

    def _go_back(self, q_rad: Float64 | None = None) -> None:
        """Close the repetition and lead the hand to the start of the next one."""
        movement, end = self._movement, self._movement.end.q_rad
        self._patient.relax()
        self._guidance.finish_repetition()
        if self._guidance.cue_relax:
            self._remarks.append(Remark("cue-relax " + " ".join(self._guidance.cue_relax)))
        self._schedule.reversals.note(reversed_on_load=False)
        movement.prepare(self.repetition + 1)
        self._back = self._lead(end if q_rad is None or not self._guidance.free else q_rad)
        self._enter("return")

    def _return(self, state: DeviceState, load_share: float) -> Setpoint:
        paused, shaper = self._movement.player.paused, self._guidance.shaper
        if self._back.done and not paused and not bool(shaper.tau_nm.any()):
            self._movement.give_up()
            self._follow(self._schedule.after_return(self.repetition, self.started_by))
            return self._movement.start
        return self._back.step(paused=paused)

    def _follow(self, after: Next) -> None:
        """Do what comes next."""
        self.reason = after.reason
        if after.remark:
            self._remarks.append(Remark(after.remark))
        if after.phase == "ramp":
            self._next_repetition()
        else:
            self._enter(after.phase)

    def _rest(self, state: DeviceState, load_share: float) -> Setpoint:
        if self._probes:
            self._probe(state.q_rad)
        elif self._after(self._ordered.rest_s):
            self._follow(self._schedule.after_rest())
        return self._movement.start

    def _probe(self, q_rad: Float64) -> None:
        """Let the hand go to where it carries no load, then lead it back: that shows how it lies."""
        if self._after(self._ordered.rest_s + PROBE_S):
            self._probes = False
            self._way = self._lead(q_rad)
            self._guidance.shaper.begin_anew(APPROACH_MULTIPLE)

    def _rest_longer(self, state: DeviceState, load_share: float) -> Setpoint:
        if self._after(REST_S):
            self._follow(self._schedule.after_rest())
        return self._movement.start

    def _await_skin_check(self, state: DeviceState, load_share: float) -> Setpoint:
        if self._ticks * self._period_s >= SKIN_CHECK_WAIT_S:
            self._follow(Next("done", "skin-check"))
        return self._movement.start

    def _stay(self, state: DeviceState, load_share: float) -> Setpoint:
        return self._movement.start

    def _next_repetition(self) -> None:
        if not self._waits:
            self._judge_the_fit()
        self.repetition += 1
        self.started_by = ""
        self._dose.next_repetition()
        self._trigger.rearm()
        self._enter("ramp")

    def _judge_the_fit(self) -> None:
        """Hold where the hand lies otherwise in the device than it did; probe where it may."""
        drift = self._drift.judge()
        self._probes = drift is not None and not drift.confirmed
        if drift is not None and drift.confirmed:
            name = self._plan.joint_names[drift.joint]
            self._remarks.append(Remark("fit-drift", True, name, drift.value_rad, DRIFT_RAD))
