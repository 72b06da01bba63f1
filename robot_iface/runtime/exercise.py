"""What the run is doing: approach, ramp, cue, move, hold, return, rest, and again.

In words: the hand is brought to the start of the path (approach), stiffness rises to what was prescribed
(ramp), in assistive mode the patient is cued and waited for (cue), the path is played (move), its end is held
(hold), the hand goes back to the start (return) and rests (rest); after the last repetition the run is done.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from robot_iface.control import AssistAsNeeded, FeedForward, Goal, Start, StartTrigger, require_mode
from robot_iface.control.assist import free_ahead
from robot_iface.errors import Refused
from robot_iface.motion import PathPlayer, PathState, QuinticPath, Setpoint
from robot_iface.runtime.heading import cued_direction, headings
from robot_iface.runtime.orders import Patient
from robot_iface.runtime.spring import TORQUE_SLEW_NM_S, Spring
from robot_iface.runtime.transfer import Transfer
from robot_iface.types import DeviceState, Float64, Plan

APPROACH_MULTIPLE = 1.0
CUE_MULTIPLE = 0.3
"""Stiffness while the patient is waited for, a multiple of the thesis gains: low, so that a weak start shows
against it."""
_FEED_FORWARD_SLEW_NM_S = 0.5
_CUE_STEP_S = 0.005
_MIN_SPEED = 0.1
_LEAVE_SLEW_RAD_S = 0.5


class Exercise:
    """The sequence of phases over all repetitions, advanced once a tick.

    Args:
        plan: What to do.
        patient: The patient's side.
        period_s: Control period.

    Raises:
        Refused: The mode is not built, or the path cannot be played.
    """

    def __init__(self, plan: Plan, patient: Patient, period_s: float) -> None:
        ordered = plan.prescription
        require_mode(ordered.mode)
        if plan.path is None:
            raise Refused("exercise", "without a path", "with a path", "plan a take")
        self._plan, self._patient, self._period_s = plan, patient, period_s
        self._assistive = ordered.mode == "assistive"
        self._path = QuinticPath(plan.path)
        self.player = PathPlayer(self._path.duration_s, period_s, ordered.speed)
        joints = len(plan.joint_names)
        still = np.zeros(joints)
        self._start = Setpoint(self._path.start_rad(), still, still)
        self._end = Setpoint(self._path.end_rad(), still, still)
        forgetting = ordered.assist_forgetting if self._assistive else 1.0
        self._assist = AssistAsNeeded(plan.joint_names, ordered.stiffness_multiple, period_s)
        self._trigger = StartTrigger(cued_direction(self._path), period_s, ordered.cue_timeout_s)
        self._cue_table = self._path.sample(np.arange(0.0, self._path.duration_s + _CUE_STEP_S, _CUE_STEP_S))
        self._headings = headings(self._cue_table)
        way = self._headings if self._assistive else None
        self._learnt = FeedForward(self._path.duration_s, plan.limits, forgetting, way)
        self._back = Transfer(self._end.q_rad, self._start.q_rad, plan.limits, period_s)
        self._way: Transfer | None = None
        self._begin_gains(still)
        self._steps: dict[str, Callable[[DeviceState, float], Setpoint]] = {
            "approach": self._approach,
            "ramp": self._ramp,
            "cue": self._cue,
            "move": self._move,
            "hold": self._hold,
            "return": self._return,
            "rest": self._rest,
            "done": lambda state, load_share: self._start,
        }
        self.phase = "approach"
        self.repetition = -1
        self.started_by = ""
        self.path_state = PathState(0.0, 0.0, 0.0, False)

    def _begin_gains(self, still: Float64) -> None:
        """Stiffness, feed-forward and counters before the first tick."""
        ordered, joints = self._plan.prescription, still.size
        self._prescribed = np.full(joints, ordered.stiffness_multiple)
        self._low = np.full(joints, CUE_MULTIPLE)
        self._spring = Spring(self._plan, APPROACH_MULTIPLE, self._period_s)
        self._no_torque = self._tau_ff = self._ahead = still
        self._ticks = 0
        self._repetition_ticks = 0
        self._slowest = ordered.speed
        self._troubled = False

    @property
    def done(self) -> bool:
        """Whether every repetition has been made and the hand is back."""
        return self.phase == "done"

    @property
    def paused(self) -> bool:
        """Whether a pause was asked for and not yet resumed."""
        return self.player.paused

    @property
    def fault(self) -> str:
        """What the path player refused; empty while it plays."""
        return self.player.fault

    def pause(self) -> None:
        """Come to rest on the path."""
        self.player.pause()

    def resume(self) -> None:
        """Go on."""
        self.player.resume()

    @property
    def stiffness_multiple(self) -> Float64:
        """Stiffness of the last tick as a multiple of the thesis gains, (J,)."""
        return self._spring.multiple

    @property
    def reference_rad(self) -> Float64:
        """The therapist's posture at the present path coordinate, (J,)."""
        if self.phase in ("move", "hold"):
            return self._reference
        return self._start.q_rad

    @property
    def repetition_age_ns(self) -> int:
        """How long this repetition has been going on, pauses left out; 0 outside one."""
        return round(self._repetition_ticks * self._period_s * 1e9)

    @property
    def repetition_timeout_ns(self) -> int:
        """Twice what a repetition takes at the slowest speed that was asked for, and ten seconds."""
        ordered = self._plan.prescription
        waits = ordered.ramp_s + ordered.cue_timeout_s + ordered.hold_s + ordered.rest_s
        expected = waits + self._path.duration_s / self._slowest + self._back.ticks * self._period_s
        return round((2.0 * expected + 10.0) * 1e9)

    def begin(self, q_rad: Float64) -> None:
        """Plan the way from where the hand is, (J,), to the path; at the beginning, and after a hold."""
        goal = self._goal_posture()
        self._way = Transfer(q_rad, goal, self._plan.limits, self._period_s)
        if self.phase == "return":
            self._back.skip()
        self._spring.soften(APPROACH_MULTIPLE)
        self._tau_ff = self._ahead = self._no_torque

    def resting_goal(self) -> Goal:
        """The start of the path, without stiffness: a goal before the first step."""
        return Goal(self._start, np.zeros_like(self._no_torque), self._no_torque, self.path_state)

    def step(self, state: DeviceState, load_share: float, active: bool) -> Goal:
        """What this tick asks for.

        Args:
            state: Newest reading.
            load_share: Largest interaction torque as a share of its limit, one tick ago.
            active: Whether the supervisor has finished its own ramp; until then the hand is held where it is.
        """
        way = self._way
        if way is not None:
            setpoint = way.step(paused=self.player.paused) if active else way.start
            if way.done:
                self._way = None
            return self._goal(setpoint, state.q_rad, self._spring.multiple, self._no_torque)
        self._ticks += 1
        if self.repetition >= 0 and not self.player.paused:
            self._repetition_ticks += 1
        setpoint = self._steps[self.phase](state, load_share)
        follows, here = self.phase in ("ramp", "move", "hold"), self.path_state.s
        tau_ff = self._learnt.torque(here, state.q_rad) if follows else self._no_torque
        multiple = self._wanted_multiple(setpoint)
        return self._goal(self._leave_ahead(setpoint, state.q_rad), state.q_rad, multiple, tau_ff)

    def slow_down_to(self, speed: float) -> None:
        """Play at this path speed, but never faster than was prescribed and rehearsed."""
        speed = min(max(speed, _MIN_SPEED), self._plan.prescription.speed)
        self._slowest = min(self._slowest, speed)
        self.player.request_speed(speed)

    def trouble(self) -> None:
        """Pain, or a latched hold, in this repetition: nothing is learnt from it and help is not raised."""
        self._troubled = True
        self._learnt.forget()

    def _leave_ahead(self, setpoint: Setpoint, q_rad: Float64) -> Setpoint:
        """Assistive: move the set-point to a patient who is ahead on the path, and back gently.

        Which way is ahead turns over where the path does; without the slew the torque would jump there.
        """
        if not self._assistive:
            return setpoint
        wanted = self._no_torque
        if self.phase == "move":
            error = setpoint.q_rad - q_rad
            here = min(int(self.path_state.s / _CUE_STEP_S), len(self._headings) - 1)
            wanted = free_ahead(error, self._headings[here]) - error
        step = _LEAVE_SLEW_RAD_S * self._period_s
        self._ahead = self._ahead + np.minimum(np.maximum(wanted - self._ahead, -step), step)
        return Setpoint(setpoint.q_rad + self._ahead, setpoint.dq_rad_s, setpoint.ddq_rad_s2)

    def _goal(self, setpoint: Setpoint, q_rad: Float64, multiple: Float64, tau_ff: Float64) -> Goal:
        if multiple is not self._spring.multiple:
            self._spring.change(multiple, np.abs(setpoint.q_rad - q_rad))
        rate = (_FEED_FORWARD_SLEW_NM_S if self.phase == "move" else TORQUE_SLEW_NM_S) * self._period_s
        self._tau_ff = self._tau_ff + np.minimum(np.maximum(tau_ff - self._tau_ff, -rate), rate)
        return Goal(setpoint, self._spring.multiple, self._tau_ff, self.path_state)

    def _wanted_multiple(self, setpoint: Setpoint) -> Float64:
        if self.phase == "rest" or (self._assistive and self.phase in ("ramp", "cue")):
            return self._low
        return self._assist.multiple(setpoint.dq_rad_s) if self._assistive else self._prescribed

    def _goal_posture(self) -> Float64:
        return self._reference if self.phase in ("move", "hold") else self._start.q_rad

    @property
    def _reference(self) -> Float64:
        return self._path.evaluate(self.path_state.s, 0.0, 0.0).q_rad

    def _enter(self, phase: str) -> None:
        self.phase, self._ticks = phase, 0

    def _after(self, seconds: float) -> bool:
        """Whether the phase has lasted this long, unless it is paused."""
        return self._ticks * self._period_s >= seconds and not self.player.paused

    def _approach(self, state: DeviceState, load_share: float) -> Setpoint:
        self._next_repetition("ramp")
        return self._start

    def _ramp(self, state: DeviceState, load_share: float) -> Setpoint:
        if self._after(self._plan.prescription.ramp_s):
            if not self._assistive:
                self._set_off("robot")
            elif self._trigger.update(state.q_rad) == Start.CUED:
                self._patient.cue(self._cue_table, _CUE_STEP_S, self._plan.prescription.speed)
                self._enter("cue")
        return self._start

    def _cue(self, state: DeviceState, load_share: float) -> Setpoint:
        start = self._trigger.update(state.q_rad)
        if start >= Start.PATIENT and not self.player.paused:
            self._set_off("patient" if start == Start.PATIENT else "robot")
        return self._start

    def _set_off(self, starter: str) -> None:
        self.started_by = starter
        self._enter("move")

    def _move(self, state: DeviceState, load_share: float) -> Setpoint:
        path = self.player.step()
        self.path_state = path
        setpoint = self._path.evaluate(path.s, path.s_dot, path.s_ddot)
        error = setpoint.q_rad - state.q_rad
        if path.s_dot > 0.0:
            self._learnt.observe(path.s, error, load_share)
            if self._assistive:
                self._assist.observe(setpoint.dq_rad_s, error, state.dq_rad_s, state.tau_interaction_nm)
                self._patient.progress(path.s)
        if path.at_end:
            self._enter("hold")
        return setpoint

    def _hold(self, state: DeviceState, load_share: float) -> Setpoint:
        if self._after(self._plan.prescription.hold_s):
            self._patient.relax()
            self._learn()
            self._back = Transfer(self._end.q_rad, self._start.q_rad, self._plan.limits, self._period_s)
            self._enter("return")
        return self._end

    def _learn(self) -> None:
        stiffness, speed = self._spring.stiffness_nm_rad, self._plan.prescription.speed
        self._learnt.learn(stiffness, speed, discard=self._troubled)
        if self._assistive:
            self._assist.finish_repetition(painful=self._troubled)
        self._troubled = False

    def _return(self, state: DeviceState, load_share: float) -> Setpoint:
        if self._back.done and not self.player.paused and not bool(self._tau_ff.any()):
            self.path_state = PathState(0.0, 0.0, 0.0, False)
            self.player.rewind()
            self._enter("rest" if self.repetition + 1 < self._plan.prescription.repetitions else "done")
            return self._start
        return self._back.step(paused=self.player.paused)

    def _rest(self, state: DeviceState, load_share: float) -> Setpoint:
        if self._after(self._plan.prescription.rest_s):
            self._next_repetition("ramp")
        return self._start

    def _next_repetition(self, phase: str) -> None:
        self.repetition += 1
        self.started_by = ""
        self._repetition_ticks = 0
        self._trigger.rearm()
        self._enter(phase)
