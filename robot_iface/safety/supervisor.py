"""The supervisor: the only holder of a writable robot, and a latched state machine over it."""

from __future__ import annotations

import dataclasses
import math

from robot_iface.errors import Refused
from robot_iface.ports import EmergencyStop, HandRobot
from robot_iface.safety.admission import admit_device, admit_enable, admit_reset
from robot_iface.safety.drive import Drive
from robot_iface.safety.envelope import Assessment, Envelope, Finding
from robot_iface.safety.watch import Outcome, Watch
from robot_iface.safety.watchdogs import Watchdogs
from robot_iface.safety.yielding import Holding, damped, nothing
from robot_iface.types import DeviceCommand, DeviceState, Float64, Limits, SafetyEvent, SafetyState

_FOLLOWING = (SafetyState.RAMP_IN, SafetyState.ACTIVE)
_PURSUING = (*_FOLLOWING, SafetyState.HOLD, SafetyState.COMPLIANT)
_LOWERED_AT_ONCE = ("pain", "held-stretch", "repetition-time-out")


class Supervisor:
    """Passes requests to a robot only while everything is well.

    One control cycle, in this order and once a tick::

        state = supervisor.read(clock.now_ns())      # the newest reading
        request = law.command(state, ...)            # computed from that reading
        outcome = supervisor.write(request, watch)   # checked, clamped, applied or replaced

    All checks run in ``write``, on the reading and on the request of the same tick, so that every fault
    acts within the tick in which it is seen. States only get more severe (HOLD < COMPLIANT < CAT1 < CAT0)
    until ``reset``:

    - READY: no requests pass. With power left over, the device brakes until it rests, then loses power.
    - RAMP_IN, ACTIVE: requests pass, their torque clamped; RAMP_IN raises the clamp over ``ramp_s``.
    - HOLD (category 2): the last command stands still; lowered at <= 20 deg/s where it holds a stretch.
    - COMPLIANT: no stiffness, damping only: the load is followed, never pushed.
    - CAT1: damped brake at once; power is cut when the hand has been still and nothing has pushed hard for
      as long as a spasm may last, at the latest after 5 s.
    - CAT0: power is cut at once. Only where the sensors or the loop cannot be trusted.

    Args:
        robot: The device. Nobody else may hold it for writing.
        limits: Limits of the driven joints, in the order of the device.
        stop: The stop that a person presses.
        period_ns: Control period.
        ramp_s: Duration of RAMP_IN.
        quick_release: Whether a worn device that locks without power can be opened by hand at once.
    """

    def __init__(
        self,
        robot: HandRobot,
        limits: Limits,
        stop: EmergencyStop,
        period_ns: int,
        *,
        ramp_s: float = 1.0,
        quick_release: bool = False,
    ) -> None:
        self._period_s = period_ns * 1e-9
        self._drive = Drive(robot, self._period_s)
        self._limits = limits
        self._stop = stop
        self._ramp_step = self._period_s / ramp_s
        self._quick_release = quick_release
        self._capabilities = capabilities = robot.capabilities
        self._names = capabilities.joint_names
        self._envelope = Envelope(limits, self._names, self._period_s)
        self._watchdogs = Watchdogs(period_ns, capabilities.period_ns)
        self._state = SafetyState.OFF
        self._ramp = 0.0
        self._now_ns = 0
        self._reading: DeviceState | None = None
        self._previous: DeviceCommand | None = None
        self._applied = nothing(len(self._names), 0)
        self._holding: Holding | None = None
        self._asked: Finding | None = None

    @property
    def state(self) -> SafetyState:
        """Present state."""
        return self._state

    @property
    def powered(self) -> bool:
        """Whether the motors have power."""
        return self._drive.powered

    @property
    def ramp(self) -> float:
        """Share of torque allowed now, 0 to 1; hand it to ``ImpedanceLaw.command``."""
        return self._ramp

    def start(self) -> None:
        """Open the device: OFF -> READY, without power.

        Raises:
            Refused: If it is started already, if the limits are not for this device, or if a worn device
                would lock the fingers without power and has no quick release.
        """
        admit_device(self._state, self._capabilities, self._limits, quick_release=self._quick_release)
        self._drive.open()
        self._state = SafetyState.READY

    def enable_edge(self) -> None:
        """A person enables the motors: READY -> RAMP_IN. Needs a reading with every joint in today's range.

        Raises:
            Refused: In any other state, while stop is pressed, or if a joint is outside its range.
        """
        admit_enable(self._state, self._stop, self._reading, self._limits, self._names)
        self._drive.enable()
        self._state = SafetyState.RAMP_IN
        self._watchdogs.forget_loads()

    def reset(self, *, present: bool) -> None:
        """A person who is present clears a latched state -> READY; nothing moves before a new enable edge.

        Raises:
            Refused: If nobody is present, stop is still pressed, or a joint still moves.
        """
        if self._state < SafetyState.HOLD:
            return
        admit_reset(self._stop, self._reading, present=present)
        self._drive.clear_faults()
        self._enter_ready()

    def finish(self) -> None:
        """Normal end of a run: -> READY; the next writes brake, and cut power once everything is still.

        A latched state is not left by this; end such a run by ``request_stop`` and write until unpowered.
        """
        if self._state in _FOLLOWING:
            self._enter_ready()

    def request_stop(self, cause: str) -> None:
        """Category 1 stop at the next ``write``, for causes that only the caller sees ("link-closed")."""
        self._asked = Finding(cause, SafetyState.CAT1, "", math.nan, math.nan)

    def read(self, now_ns: int) -> DeviceState:
        """The newest state; once a tick, before the request is computed.

        A device that cannot be read any more leaves the last reading standing and is cut off in ``write``.

        Raises:
            Refused: If the very first reading fails: there is nothing to go on with.
        """
        self._now_ns = now_ns
        reading = self._drive.read()
        if reading is not None:
            self._reading = reading
        if self._reading is None:
            raise Refused("device", f"silent ({self._drive.lost})", "readable", "check its connection")
        return self._reading

    def write(self, request: DeviceCommand, watch: Watch) -> Outcome:
        """Check reading, request and watchdogs; act; apply the request as far as the limits allow.

        Args:
            request: What the control law asks for.
            watch: What the loop knows about everything but the device.

        Returns:
            What was applied, and the transitions of this tick.

        Raises:
            Refused: If ``read`` was never called.
        """
        state = self._reading
        if state is None:
            raise Refused("supervisor", "without a reading", "read once a tick", "call read before write")
        following = self._state in _FOLLOWING
        wanted = request if following else self._own_command(state, request.seq)
        found = self._envelope.assess(
            state, wanted, self._previous, self._cap(), moving=self._state in _PURSUING
        )
        events = self._transitions(self._findings(state, wanted, watch, found))
        if events and self._state > SafetyState.ACTIVE:
            wanted = self._own_command(state, request.seq)
            found = self._envelope.assess(state, wanted, None, self._cap(), moving=False)
        self._previous = wanted if self._state in _FOLLOWING else None
        self._drive.note(found.load_share)
        tau = self._act(state, wanted, found)
        load, powered = found.load_share, self._drive.powered
        return Outcome(
            self._applied, found.requested_tau_nm, tau, self._state, self._ramp, load, powered, events
        )

    def close(self) -> None:
        """Cut power and disconnect, at once. A hand that is held open snaps: see ``brake_and_close``."""
        if self._state is SafetyState.OFF:
            return
        self._drive.close()
        self._state = SafetyState.OFF

    def _own_command(self, state: DeviceState, seq: int) -> DeviceCommand:
        """What the supervisor itself wants in a state in which requests do not pass."""
        if self._state is SafetyState.HOLD and self._holding is not None:
            return self._holding.command(state, seq)
        if self._drive.powered:
            return damped(len(self._names), seq)
        return nothing(len(self._names), seq)

    def _cap(self) -> Float64:
        """Torque clamp of the present state: the motor's cap for damping, the patient's for all else."""
        if self._state in _FOLLOWING or self._state is SafetyState.HOLD:
            return self._envelope.follow_cap_nm * self._ramp
        return self._envelope.motor_cap_nm

    def _findings(
        self, state: DeviceState, wanted: DeviceCommand, watch: Watch, assessment: Assessment
    ) -> list[Finding]:
        """Everything that is wrong in this tick."""
        found: list[Finding] = []
        if self._stop.pressed():
            found.append(Finding("e-stop", SafetyState.CAT1, "", math.nan, math.nan))
        found.extend(assessment.findings)
        if self._drive.lost:
            found.append(Finding(f"device-lost {self._drive.lost}", SafetyState.CAT0, "", math.nan, math.nan))
        if self._asked is not None:
            found.append(self._asked)
            self._asked = None
        checks = [self._watchdogs.trust(state, self._now_ns)]
        if self._state in _PURSUING:
            checks.append(self._watchdogs.link(watch))
            checks.append(self._watchdogs.load(state, wanted, assessment.load_share))
        found.extend(finding for finding in checks if finding is not None)
        return found

    def _transitions(self, found: list[Finding]) -> tuple[SafetyEvent, ...]:
        """Enter the most severe state asked for, if it is more severe than the present one."""
        if not found:
            return ()
        worst = max(found, key=lambda finding: finding.state)
        if worst.state > self._state:
            self._enter(worst)
            return (self._event(worst),)
        return self._lower(found)

    def _lower(self, found: list[Finding]) -> tuple[SafetyEvent, ...]:
        """In HOLD: begin to lower where a finding asks for it."""
        holding = self._holding
        causes = [finding for finding in found if finding.cause in _LOWERED_AT_ONCE]
        if holding is None or holding.lowering or not causes:
            return ()
        holding.lowering = True
        return (self._event(causes[0]),)

    def _event(self, finding: Finding) -> SafetyEvent:
        """What is reported of a finding that has changed something."""
        joint, value, bound = finding.joint, finding.value, finding.bound
        return SafetyEvent(self._now_ns, finding.cause, self._state, joint, value, bound)

    def _enter(self, finding: Finding) -> None:
        """Enter a latched state."""
        self._state = finding.state
        if finding.state is SafetyState.HOLD:
            self._holding = Holding(self._applied, self._limits.tau_interaction_nm, self._period_s)
            self._holding.lowering = finding.cause in _LOWERED_AT_ONCE
            return
        self._holding = None
        if finding.state is SafetyState.CAT1:
            self._drive.brake()
        elif finding.state is SafetyState.CAT0:
            self._drive.cut_power()

    def _enter_ready(self) -> None:
        """READY: brake if there is power; no goal is left over."""
        self._state = SafetyState.READY
        self._ramp = 0.0
        self._holding = None
        self._previous = None
        self._drive.brake()

    def _act(self, state: DeviceState, wanted: DeviceCommand, assessment: Assessment) -> Float64:
        """Give the device what the state allows and return the torque that it then applies, (J,)."""
        if not self._drive.powered:
            self._applied = wanted = nothing(len(self._names), wanted.seq)
            return wanted.tau_ff_nm
        if self._state in (SafetyState.READY, SafetyState.CAT1):
            self._applied = wanted
            self._drive.settle(state)
            return assessment.applied_tau_nm
        shift = assessment.applied_tau_nm - assessment.requested_tau_nm
        if bool(shift.any()):
            wanted = dataclasses.replace(wanted, tau_ff_nm=wanted.tau_ff_nm + shift)
        self._applied = wanted
        self._drive.send(wanted)
        self._advance_ramp()
        return assessment.applied_tau_nm

    def _advance_ramp(self) -> None:
        """RAMP_IN lets a little more torque pass every tick, until all of it does."""
        if self._state is SafetyState.RAMP_IN:
            self._ramp = min(self._ramp + self._ramp_step, 1.0)
            if self._ramp >= 1.0:
                self._state = SafetyState.ACTIVE
