"""One control cycle on one screen, and a run made of it."""

from __future__ import annotations

from robot_iface.control import ImpedanceLaw, thesis_gains
from robot_iface.errors import Refused
from robot_iface.runtime.exercise import Exercise
from robot_iface.runtime.live import LiveSample
from robot_iface.runtime.orders import Order, Pain, Pause, Reset, Resume, SetSpeed
from robot_iface.runtime.record import Recorder
from robot_iface.runtime.rig import Rig, ScheduledStop, Surroundings
from robot_iface.runtime.seal import check_certificate
from robot_iface.safety import Outcome, Supervisor, Watch, brake_and_close
from robot_iface.types import (
    Certificate,
    DeviceCommand,
    DeviceState,
    Float64,
    PhaseChange,
    Plan,
    RunEnd,
    SafetyEvent,
    SafetyState,
)

ORDERS_EVERY_TICKS = 5
LIVE_EVERY_TICKS = 10
PHASE_EVERY_TICKS = 100
UNATTENDED_HOLD_S = 60.0
"""A hold or pause that nobody ends is braked and powered off after this time."""
_RUNNING = (SafetyState.RAMP_IN, SafetyState.ACTIVE)
_HELD = (SafetyState.HOLD, SafetyState.COMPLIANT, SafetyState.READY)
_STOPPED = (SafetyState.CAT1, SafetyState.CAT0)


def run(plan: Plan, certificate: Certificate, rig: Rig, around: Surroundings) -> RunEnd:
    """Run a rehearsed plan to its end, or to the stop that ends it.

    Raises:
        Refused: The certificate is not that of this plan, or the device does not fit it. Nothing has moved.
    """
    check_certificate(plan, certificate)
    return perform(plan, rig, around)


def perform(plan: Plan, rig: Rig, around: Surroundings) -> RunEnd:
    """Run a plan without asking for its certificate: only a rehearsal may, and only on a simulation.

    Raises:
        Refused: The stop is pressed, or the device does not fit the plan. Nothing has moved.
    """
    if around.stop.pressed():
        raise Refused("the stop", "pressed", "clear", "look at the patient, reset the stop and start again")
    names = rig.robot.capabilities.joint_names
    if plan.joint_names != names:
        given = ", ".join(plan.joint_names)
        raise Refused(
            "reference path joints", given, ", ".join(names), "rebuild the reference for this device"
        )
    cycle = Cycle(plan, rig, around)
    around.begun()
    try:
        cycle.open()
        while cycle.tick():
            pass
    finally:
        cycle.close()
    return cycle.end()


class Cycle:
    """The control loop of one run.

    Args:
        plan: What to do.
        rig: With what.
        around: Who listens and who orders.
    """

    def __init__(self, plan: Plan, rig: Rig, around: Surroundings) -> None:
        period_ns = rig.robot.capabilities.period_ns
        self._plan, self._clock, self._around = plan, rig.clock, around
        self._period_s = period_ns * 1e-9
        stop = ScheduledStop(around.stop, rig.clock, plan.stop_at_s)
        self._supervisor = Supervisor(
            rig.robot, plan.limits, stop, period_ns, ramp_s=plan.prescription.ramp_s
        )
        self._exercise = Exercise(plan, rig.patient, self._period_s)
        self._law = ImpedanceLaw(thesis_gains(plan.joint_names), plan.limits)
        self._recorder = Recorder(around.sink, len(plan.joint_names))
        self._ticks = 0
        self._t0_ns = self._t_ns = rig.clock.now_ns()
        self._load_share = 0.0
        self._pain = False
        self._waiting_ticks = 0
        self._state = SafetyState.OFF
        self._goal = self._exercise.resting_goal()
        self._said: tuple[str, int, str] = ("", -2, "")

    def open(self) -> None:
        """Open the device and give the first enable: starting the run is the person's act."""
        self._supervisor.start()
        state = self._wait_and_read()
        self._enable(state)

    def tick(self) -> bool:
        """One control cycle: orders, read, law, write, record. False when the run is over."""
        state = self._wait_and_read()
        if self._ticks % ORDERS_EVERY_TICKS == 0:
            self._take_orders(state)
        exercise, supervisor = self._exercise, self._supervisor
        active = supervisor.state == SafetyState.ACTIVE
        if supervisor.state not in _STOPPED:
            self._goal = exercise.step(state, self._load_share, active)
        goal = self._goal
        request = self._law.command(state, goal, supervisor.ramp, self._ticks)
        outcome = supervisor.write(request, self._watch())
        self._load_share = outcome.load_share
        self._record(state, request, outcome)
        self._follow(outcome)
        return self._goes_on(outcome)

    def _goes_on(self, outcome: Outcome) -> bool:
        """Whether the run needs another tick: it ends once exercise or stop have braked the hand."""
        if not (self._exercise.done or outcome.safety_state in _STOPPED):
            return True
        return outcome.powered

    def close(self) -> None:
        """Disconnect without power; a hand that an error has left with power is braked to rest first."""
        brake_and_close(self._supervisor, self._next_tick)

    def end(self) -> RunEnd:
        """Send and return how the run ended."""
        clock = self._clock
        finished = RunEnd(
            simulated_s=(self._t_ns - self._t0_ns) * 1e-9,
            completed=self._exercise.done and self._state not in _STOPPED,
            state=self._state,
            late_p99_ns=clock.late_ns(99.0),
            overruns=clock.overruns,
            digest=self._recorder.end(),
        )
        self._around.sink(finished)
        return finished

    def _wait_and_read(self) -> DeviceState:
        self._t_ns = self._next_tick()
        self._ticks += 1
        return self._supervisor.read(self._t_ns)

    def _next_tick(self) -> int:
        """Wait for the next tick and return its time, ns."""
        self._clock.wait_next_tick()
        return self._clock.now_ns()

    def _enable(self, state: DeviceState) -> None:
        """The enable edge: from here the hand is led to the path."""
        self._supervisor.enable_edge()
        self._exercise.begin(state.q_rad)
        self._exercise.resume()

    def _take_orders(self, state: DeviceState) -> None:
        order = self._around.inbox.take(self._t_ns - self._t0_ns)
        while order is not None:
            try:
                self._obey(order, state)
            except Refused as refused:  # the order came too early or too late; the run itself goes on
                self._note(f"order-refused {refused.thing}")
            order = self._around.inbox.take(self._t_ns - self._t0_ns)

    def _obey(self, order: Order, state: DeviceState) -> None:
        """Do what a person orders."""
        now = self._supervisor.state
        match order:
            case Pause():
                self._exercise.pause()
            case Resume() if now == SafetyState.READY and not self._exercise.done:
                self._enable(state)
            case Resume() if now in _RUNNING:
                self._exercise.resume()
            case SetSpeed():
                self._exercise.slow_down_to(order.speed)
            case Pain():
                self._pain = True
            case Reset() if now in (SafetyState.HOLD, SafetyState.COMPLIANT):
                self._supervisor.reset(present=True)
                self._note("reset")
            case _:
                raise Refused(
                    type(order).__name__, f"given in {now.name}", "given in its turn", "reset first"
                )

    def _watch(self) -> Watch:
        """What the loop knows about everything but the device."""
        realtime, monitor, exercise = self._plan.realtime, self._around.monitor, self._exercise
        pain, self._pain = self._pain, False
        return Watch(
            heartbeat_age_ns=monitor.heartbeat_age_ns() if realtime else 0,
            operator_age_ns=monitor.operator_age_ns() if realtime else 0,
            path_fault=bool(exercise.fault),
            overruns_in_row=self._clock.overruns_in_row,
            repetition_age_ns=exercise.repetition_age_ns,
            repetition_timeout_ns=exercise.repetition_timeout_ns if exercise.repetition >= 0 else 0,
            pain=pain,
        )

    def _follow(self, outcome: Outcome) -> None:
        """Let the exercise follow what the supervisor decided, and end what nobody attends to."""
        exercise, state = self._exercise, outcome.safety_state
        self._state = state
        if outcome.events and state in (*_HELD, *_STOPPED):
            exercise.trouble()
            exercise.pause()
            if state in _STOPPED:
                self._around.monitor.latched()
        if exercise.done and state in _RUNNING:
            self._supervisor.finish()
        waiting = exercise.paused or state in _HELD
        self._waiting_ticks = self._waiting_ticks + 1 if waiting else 0
        if self._waiting_ticks * self._period_s > UNATTENDED_HOLD_S:
            self._supervisor.request_stop("unattended")

    def _record(self, state: DeviceState, request: DeviceCommand, outcome: Outcome) -> None:
        """Tell the recorder, and now and then the live page, what this tick was."""
        exercise, recorder = self._exercise, self._recorder
        stopped = outcome.safety_state in _STOPPED
        path = exercise.path_state
        speed = 0.0 if stopped else path.s_dot
        for event in outcome.events:
            recorder.say(event)
        said = ("stopped" if stopped else exercise.phase, exercise.repetition, exercise.started_by)
        if said != self._said or self._ticks % PHASE_EVERY_TICKS == 0:
            self._said = said
            recorder.say(
                PhaseChange(self._t_ns, said[1], said[0], said[2], path.s, speed, exercise.stiffness_multiple)
            )
        reference = exercise.reference_rad
        rows = (
            *(state.q_rad, state.dq_rad_s, state.tau_nm, state.tau_interaction_nm, reference),
            *(request.q_rad, request.dq_rad_s, request.stiffness_nm_rad, request.damping_nms_rad),
            *(request.tau_ff_nm, outcome.requested_tau_nm, outcome.applied_tau_nm),
        )
        recorder.tick(self._t_ns, path.s, speed, int(outcome.safety_state), rows)
        if self._ticks % LIVE_EVERY_TICKS == 0 or outcome.events:
            self._publish(state, outcome, reference, speed)

    def _publish(self, state: DeviceState, outcome: Outcome, reference_rad: Float64, speed: float) -> None:
        phase, repetition, starter = self._said
        self._around.monitor.publish(
            LiveSample(
                t_ns=self._t_ns,
                q_rad=state.q_rad,
                q_reference_rad=reference_rad,
                tau_interaction_nm=state.tau_interaction_nm,
                path_s=self._exercise.path_state.s,
                path_speed=speed,
                repetition=repetition,
                phase=phase,
                started_by=starter,
                safety_state=outcome.safety_state,
                stiffness_multiple=self._exercise.stiffness_multiple,
            )
        )

    def _note(self, cause: str) -> None:
        """Record a person's act that is no transition of the supervisor's own."""
        nan = float("nan")
        self._recorder.say(SafetyEvent(self._t_ns, cause, self._supervisor.state, "", nan, nan))
