"""Tells recorder and live page what a tick was."""

from __future__ import annotations

from robot_iface.runtime.live import LiveSample
from robot_iface.runtime.record import Recorder
from robot_iface.runtime.rig import Surroundings
from robot_iface.runtime.task import Task
from robot_iface.safety import Outcome
from robot_iface.types import DeviceCommand, DeviceState, PhaseChange, SafetyEvent, SafetyState

LIVE_EVERY_TICKS = 10
PHASE_EVERY_TICKS = 100
_STOPPED = (SafetyState.CAT1, SafetyState.CAT0)


class Scribe:
    """Writes down a run: every tick, every change of phase, and the newest state for the live page.

    Args:
        around: Who listens.
        task: What the run is busy with.
        joints: Number of driven joints J.
    """

    def __init__(self, around: Surroundings, task: Task, joints: int) -> None:
        self._task, self._monitor = task, around.monitor
        self._recorder = Recorder(around.sink, joints)
        self._ticks = 0
        self._phase, self._repetition, self._starter = "", -2, ""

    def write(self, t_ns: int, state: DeviceState, request: DeviceCommand, outcome: Outcome) -> None:
        """Take one tick."""
        task, recorder = self._task, self._recorder
        self._ticks += 1
        stopped = outcome.safety_state in _STOPPED
        path = task.path_state
        speed = 0.0 if stopped or outcome.reversing else path.s_dot
        for event in outcome.events:
            recorder.say(event)
        phase = "stopped" if stopped else task.phase
        if (
            self._ticks % PHASE_EVERY_TICKS == 0
            or phase != self._phase
            or task.repetition != self._repetition
            or task.started_by != self._starter
        ):
            self._phase, self._repetition, self._starter = phase, task.repetition, task.started_by
            place = (self._repetition, phase, self._starter, path.s, speed)
            recorder.say(PhaseChange(t_ns, *place, task.stiffness_multiple.copy()))
        rows = (
            *(state.q_rad, state.dq_rad_s, state.tau_nm, state.tau_interaction_nm, task.reference_rad),
            *(request.q_rad, request.dq_rad_s, request.stiffness_nm_rad, request.damping_nms_rad),
            *(request.tau_ff_nm, outcome.requested_tau_nm, outcome.applied_tau_nm),
        )
        recorder.tick(t_ns, path.s, speed, outcome.safety_state, rows)
        if self._ticks % LIVE_EVERY_TICKS == 0 or outcome.events:
            self._publish(t_ns, state, outcome, speed)

    def say(self, event: SafetyEvent) -> None:
        """Write down an event."""
        self._recorder.say(event)

    def end(self) -> str:
        """Send what is left and return the digest of everything."""
        return self._recorder.end()

    def _publish(self, t_ns: int, state: DeviceState, outcome: Outcome, speed: float) -> None:
        task = self._task
        self._monitor.publish(
            LiveSample(
                t_ns=t_ns,
                q_rad=state.q_rad,
                q_reference_rad=task.reference_rad,
                tau_interaction_nm=state.tau_interaction_nm,
                path_s=task.path_state.s,
                path_speed=speed,
                repetition=self._repetition,
                phase=self._phase,
                started_by=self._starter,
                safety_state=outcome.safety_state,
                stiffness_multiple=task.stiffness_multiple,
            )
        )
