"""One control cycle on one screen, and a run made of it."""

from __future__ import annotations

import time

from robot_iface.control import make_law
from robot_iface.errors import Refused
from robot_iface.runtime.choice import make_task
from robot_iface.runtime.orders import Advance, Order, Pain, Pause, Reset, Resume, Reverse, SetSpeed
from robot_iface.runtime.rig import Rig, ScheduledStop, Surroundings
from robot_iface.runtime.scribe import Scribe
from robot_iface.runtime.seal import check_certificate
from robot_iface.safety import Outcome, Supervisor, Watch, admit_limits, brake_and_close
from robot_iface.types import Certificate, DeviceState, Plan, RunEnd, SafetyEvent, SafetyState

ORDERS_EVERY_TICKS = 5
UNATTENDED_HOLD_S = 60.0
"""A hold or pause that nobody ends is braked and powered off after this time."""
COMPLETE = ("repetitions", "minutes", "sweep")
"""Reasons for which a run ends as it was ordered."""
_CALM = Watch()
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
        Refused: The stop is pressed, the device does not fit the plan, or the limits do not hold today.
            Nothing has moved.
    """
    if around.stop.pressed():
        raise Refused("the stop", "pressed", "clear", "look at the patient, reset the stop and start again")
    names = rig.robot.capabilities.joint_names
    if plan.joint_names != names:
        given = ", ".join(plan.joint_names)
        raise Refused(
            "reference path joints", given, ", ".join(names), "rebuild the reference for this device"
        )
    admit_limits(plan.limits, rig.robot.capabilities, plan.wrist_rad, time.time_ns())
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
        capabilities = rig.robot.capabilities
        self._plan, self._clock, self._around = plan, rig.clock, around
        self._period_s = capabilities.period_ns * 1e-9
        stop = ScheduledStop(around.stop, rig.clock, plan.stop_at_s)
        self._supervisor = Supervisor(
            rig.robot, plan.limits, stop, capabilities.period_ns, ramp_s=plan.prescription.ramp_s
        )
        self._task = make_task(plan, rig.patient, self._period_s)
        self._law = make_law(plan, capabilities)
        self._scribe = Scribe(around, self._task, len(plan.joint_names))
        self._ticks = self._waiting_ticks = 0
        self._t0_ns = self._t_ns = rig.clock.now_ns()
        self._load_share = 0.0
        self._pain = self._reversing = False
        self._state = SafetyState.OFF
        self._goal = self._task.resting_goal()
        self._stopped_by = ""
        self._reversals = 0

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
        task, supervisor = self._task, self._supervisor
        if supervisor.state not in _STOPPED and not self._reversing:
            self._goal = task.step(state, self._load_share, supervisor.state == SafetyState.ACTIVE)
        request = self._law.command(state, self._goal, supervisor.ramp, self._ticks)
        outcome = supervisor.write(request, self._watch())
        self._load_share = outcome.load_share
        self._scribe.write(self._t_ns, state, request, outcome)
        self._follow(outcome, state)
        return self._goes_on(outcome)

    def _goes_on(self, outcome: Outcome) -> bool:
        """Whether the run needs another tick: it ends once task or stop have braked the hand."""
        if not (self._task.done or outcome.safety_state in _STOPPED):
            return True
        return outcome.powered

    def close(self) -> None:
        """Disconnect without power; a hand that an error has left with power is braked to rest first."""
        brake_and_close(self._supervisor, self._next_tick)

    def end(self) -> RunEnd:
        """Send and return how the run ended."""
        clock, task = self._clock, self._task
        ended = task.done and self._state not in _STOPPED
        finished = RunEnd(
            simulated_s=(self._t_ns - self._t0_ns) * 1e-9,
            completed=ended and task.reason in COMPLETE,
            state=self._state,
            late_p99_ns=clock.late_ns(99.0),
            overruns=clock.overruns,
            digest=self._scribe.end(),
            reason=task.reason if ended else self._stopped_by,
            reversals=self._reversals,
            assistance=task.assistance,
            scheduling=clock.scheduling,
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
        """The enable edge: from here the hand is led to where the task wants it."""
        self._supervisor.enable_edge()
        self._task.begin(state.q_rad)
        self._task.resume()

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
        now, task = self._supervisor.state, self._task
        match order:
            case Pause():
                task.pause()
            case Resume() if now == SafetyState.READY and not task.done:
                self._enable(state)
            case Resume() if now in _RUNNING:
                task.resume()
            case Reverse() if now in _RUNNING:
                task.reverse()
            case Advance() if now in _RUNNING:
                task.advance()
            case SetSpeed():
                task.slow_down_to(order.speed)
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
        task, realtime = self._task, self._plan.realtime
        age_ns = task.repetition_age_ns if task.repetition >= 0 else 0
        late = age_ns > task.repetition_timeout_ns
        if not (realtime or late or self._pain or task.fault):
            return _CALM
        monitor, pain, self._pain = self._around.monitor, self._pain, False
        return Watch(
            heartbeat_age_ns=monitor.heartbeat_age_ns() if realtime else 0,
            operator_age_ns=monitor.operator_age_ns() if realtime else 0,
            path_fault=bool(task.fault),
            overruns_in_row=self._clock.overruns_in_row,
            repetition_age_ns=age_ns,
            repetition_timeout_ns=task.repetition_timeout_ns,
            pain=pain,
        )

    def _follow(self, outcome: Outcome, state: DeviceState) -> None:
        """Let the task follow what the supervisor decided, and end what nobody attends to."""
        task, supervisor, now = self._task, self._supervisor, outcome.safety_state
        self._state = now
        if outcome.events:
            self._heed(outcome.events[-1])
        self._go_back(outcome, state)
        remark = task.take_remark()
        if remark is not None and remark.holds:
            supervisor.request_hold(remark.cause, remark.joint, remark.value, remark.bound)
        elif remark is not None:
            self._note(remark.cause, remark.joint, remark.value, remark.bound)
        if now in _RUNNING and task.done:
            supervisor.finish()
        elif now in _RUNNING and task.reason:
            supervisor.request_stop(task.reason)
        self._waiting_ticks = self._waiting_ticks + 1 if task.paused or now in _HELD else 0
        if self._waiting_ticks * self._period_s > UNATTENDED_HOLD_S:
            supervisor.request_stop("unattended")

    def _heed(self, event: SafetyEvent) -> None:
        """A transition: what holds or stops the run is trouble for its task."""
        if event.state not in (*_HELD, *_STOPPED):
            return
        self._task.trouble()
        self._task.pause()
        if event.state in _STOPPED:
            self._stopped_by = event.cause
            self._around.monitor.latched()

    def _go_back(self, outcome: Outcome, state: DeviceState) -> None:
        """While the supervisor goes back on a load, the task waits; then it has the hand again, elsewhere."""
        if outcome.reversing and not self._reversing:
            self._reversals += 1
        self._reversing = outcome.reversing
        if outcome.reversed:
            self._task.reversed_on_load(state.q_rad)

    def _note(
        self, cause: str, joint: str = "", value: float = float("nan"), bound: float = float("nan")
    ) -> None:
        """Record a person's act, or the task's, that is no transition of the supervisor's own."""
        self._scribe.say(SafetyEvent(self._t_ns, cause, self._supervisor.state, joint, value, bound))
