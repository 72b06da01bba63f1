"""What the modes ask for in a tick, and what they learn between repetitions."""

from __future__ import annotations

import numpy as np

from robot_iface.control import AssistAsNeeded, FeedForward, Goal, learning_share
from robot_iface.motion import Setpoint
from robot_iface.runtime.movement import Movement
from robot_iface.runtime.shaper import Shaper
from robot_iface.types import DeviceState, Float64, Plan

APPROACH_MULTIPLE = 1.0
CUE_MULTIPLE = 0.3
"""Stiffness while the patient is waited for, a multiple of the thesis gains: low, so that a weak start shows
against it."""
FREE_FEEDBACK = 0.8
"""Share of the interaction torque that the motors take off a patient who moves alone."""
_FREE_PHASES = ("move", "hold")
_OPPOSITION_SLEW_PER_S = 1.0


class Guidance:
    """Goals of one mode.

    Passive and assistive lead the hand along the path, with what was learnt and as much help as is needed.
    Transparent and resistive let go of it while the patient moves: no stiffness, but soft walls at the ends
    of today's range; what the patient feels is then taken off, or opposed.

    Args:
        plan: What is ordered.
        movement: What is played.
        period_s: Control period.
    """

    def __init__(self, plan: Plan, movement: Movement, period_s: float) -> None:
        ordered, joints = plan.prescription, len(plan.joint_names)
        self._movement = movement
        self.assistive = ordered.mode == "assistive"
        self.free = ordered.mode in ("transparent", "resistive")
        forgetting = ordered.assist_forgetting if self.assistive else 1.0
        way = movement.headings_rad if self.assistive else None
        share = learning_share(plan.joint_names, ordered.space)
        self._learnt = FeedForward(movement.duration_s, plan.limits, forgetting, way, share)
        self._assist = AssistAsNeeded(
            plan.joint_names,
            ordered.stiffness_multiple,
            period_s,
            by_digit=ordered.assistance,
            span_rad=movement.span_rad,
        )
        self.shaper = Shaper(plan, APPROACH_MULTIPLE, period_s)
        led = APPROACH_MULTIPLE if self.free else ordered.stiffness_multiple
        self._led: Float64 = np.full(joints, min(led, ordered.stiffness_multiple))
        self._leading: Float64 = np.full(joints, min(APPROACH_MULTIPLE, ordered.stiffness_multiple))
        self._low: Float64 = np.full(joints, min(CUE_MULTIPLE, ordered.stiffness_multiple))
        self._none: Float64 = np.zeros(joints)
        self._speed = ordered.speed
        self._feedback = FREE_FEEDBACK if ordered.mode == "transparent" else 0.0
        self._opposition = ordered.resistance if ordered.mode == "resistive" else 0.0
        self._opposition_step = _OPPOSITION_SLEW_PER_S * period_s
        self._opposing = 0.0
        self._troubled = self._released = False

    @property
    def assistance(self) -> tuple[tuple[float, ...], ...]:
        """Assistance reached, as ``Prescription.assistance``; empty where none adapts."""
        return self._assist.by_digit() if self.assistive else ()

    @property
    def cue_relax(self) -> tuple[str, ...]:
        """Digits that oppose the more the more they are helped: the patient is to relax them."""
        return self._assist.cue_relax if self.assistive else ()

    def lets_go(self, phase: str) -> bool:
        """Whether the hand is free in this phase."""
        return self.free and phase in _FREE_PHASES

    def goal(self, phase: str, setpoint: Setpoint, state: DeviceState) -> Goal:
        """What this tick asks for in a phase, with its set-point."""
        movement, shaper = self._movement, self.shaper
        path, q = movement.state, state.q_rad
        if self.lets_go(phase):
            return self._free(phase, state)
        self._released = False
        self._oppose(0.0)
        tau = self._none
        if phase in ("ramp", "move", "hold") and not self.free:
            tau = self._learnt.torque(path.s, q)
        wanted = self._wanted(phase, setpoint)
        if self.assistive:
            heading = movement.heading() if phase == "move" else self._none
            setpoint = shaper.lead(setpoint, q, heading, -1.0 if path.s_dot < 0.0 else 1.0)
        shaper.ease(setpoint, q, wanted, tau, quick=phase == "move")
        return Goal(setpoint, shaper.multiple, shaper.tau_nm, path, 0.0, self._opposing)

    def _free(self, phase: str, state: DeviceState) -> Goal:
        """The hand is let go of gently, as it was held at the start of the path; then it is free."""
        movement, shaper = self._movement, self.shaper
        if not self._released:
            self._released = not bool(shaper.multiple.any())
            shaper.ease(movement.start, state.q_rad, self._none, self._none, quick=False)
            return Goal(movement.start, shaper.multiple, shaper.tau_nm, movement.state)
        setpoint, multiple = shaper.let_go(state.q_rad, state.dq_rad_s)
        self._oppose(self._opposition if phase == "move" else 0.0)
        return Goal(setpoint, multiple, self._none, movement.state, self._feedback, self._opposing)

    def _oppose(self, wanted: float) -> None:
        """Take opposition one tick towards what is wanted; a step of it would be a step of torque."""
        change = wanted - self._opposing
        self._opposing += min(max(change, -self._opposition_step), self._opposition_step)

    def along(self, setpoint: Setpoint, state: DeviceState) -> Goal:
        """What a tick asks for on the way from where the hand was to the path."""
        shaper = self.shaper
        self._oppose(0.0)
        shaper.ease(setpoint, state.q_rad, self._leading, self._none, quick=False)
        return Goal(setpoint, shaper.multiple, shaper.tau_nm, self._movement.state)

    def resting_goal(self) -> Goal:
        """A goal without stiffness, before the first step."""
        return Goal(self._movement.start, self._none, self._none, self._movement.state)

    def observe(self, setpoint: Setpoint, state: DeviceState, load_share: float) -> None:
        """Note a tick in which the path moved on."""
        if self.free:
            return
        error = setpoint.q_rad - state.q_rad
        self._learnt.observe(self._movement.state.s, error, load_share)
        if self.assistive:
            self._assist.observe(setpoint.dq_rad_s, error, state.dq_rad_s, state.tau_interaction_nm)

    def trouble(self) -> None:
        """Pain, or a latched state: nothing is learnt from this repetition and help is not raised."""
        self._troubled = True
        self._learnt.forget()

    def finish_repetition(self, *, reversed_on_load: bool = False) -> None:
        """Learn from a repetition."""
        if not self.free:
            discard = self._troubled or reversed_on_load
            self._learnt.learn(self.shaper.stiffness_nm_rad, self._speed, discard=discard)
        if self.assistive:
            self._assist.finish_repetition(reversed_on_load=reversed_on_load, painful=self._troubled)
        self._troubled = False

    def _wanted(self, phase: str, setpoint: Setpoint) -> Float64:
        if phase == "probe":
            return self._none
        if phase in ("rest", "rest-proposed", "skin-check"):
            return self._low
        if phase in ("ramp", "cue") and (self.assistive or self.free):
            return self._low
        if self.assistive:
            return self._assist.multiple(setpoint.dq_rad_s)
        return self._led
