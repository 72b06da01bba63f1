"""The supervisor: the only holder of a writable robot, and a latched state machine over it."""

from __future__ import annotations

import math

from robot_iface.errors import Refused
from robot_iface.ports import EmergencyStop, HandRobot
from robot_iface.safety.admission import admit_device, admit_enable, admit_reset, admit_shape
from robot_iface.safety.drive import Drive
from robot_iface.safety.envelope import Assessment, Finding
from robot_iface.safety.inspection import Inspection
from robot_iface.safety.ramp import Ramp
from robot_iface.safety.response import Response
from robot_iface.safety.reversal import Backing
from robot_iface.safety.watch import Outcome, Watch
from robot_iface.safety.yielding import nothing
from robot_iface.types import DeviceCommand, DeviceState, Float64, Limits, SafetyEvent, SafetyState

_FOLLOWING = (SafetyState.RAMP_IN, SafetyState.ACTIVE)
_GUIDED = (*_FOLLOWING, SafetyState.HOLD)
_PURSUING = (*_FOLLOWING, SafetyState.HOLD, SafetyState.COMPLIANT)


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
    - RAMP_IN, ACTIVE: requests pass, their torque clamped; RAMP_IN raises the clamp over ``ramp_s``. In
      ACTIVE a load that opposes the motion is gone back on by the supervisor itself (``Outcome.reversing``);
      after that its torque is clamped at half for a while.
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

    Raises:
        Refused: The limits are not for this device.
    """

    def __init__(
        self, robot: HandRobot, limits: Limits, stop: EmergencyStop, period_ns: int, *, ramp_s: float = 1.0
    ) -> None:
        self._period_s = period_ns * 1e-9
        self._limits = limits
        self._stop = stop
        self._capabilities = capabilities = robot.capabilities
        self._names = capabilities.joint_names
        admit_shape(limits, capabilities)
        self._drive = Drive(robot, self._period_s)
        self._inspection = Inspection(limits, capabilities, stop, period_ns)
        self._state = SafetyState.OFF
        self._ramp = Ramp(self._period_s / ramp_s)
        self._now_ns = 0
        self._reading: DeviceState | None = None
        self._previous: DeviceCommand | None = None
        self._continued = False
        self._applied = nothing(len(self._names), 0)
        self._response = Response(limits, self._period_s)
        self._reversed = False

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
        return self._ramp.share

    def start(self) -> None:
        """Open the device: OFF -> READY, without power.

        Raises:
            Refused: If it is started already, or if a worn device would lock the fingers without power and
                has no quick release.
        """
        admit_device(self._state, self._capabilities)
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
        self._inspection.forget_loads()

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
        self._inspection.ask_for_stop(cause)

    def request_hold(
        self, cause: str, joint: str = "", value: float = math.nan, bound: float = math.nan
    ) -> None:
        """HOLD at the next ``write``, for causes that only the task sees ("fit-drift")."""
        self._inspection.ask_for_hold(cause, joint, value, bound)

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
        response, pursuing = self._response, self._state in _PURSUING
        passes = self._state in _FOLLOWING and not response.reversing
        wanted = request if passes else response.command(state, request.seq, powered=self._drive.powered)
        assess = self._inspection.envelope.assess
        stepped = self._previous is not None
        found = assess(
            state, wanted, self._cap(), stepped=stepped, continued=self._continued, moving=pursuing
        )
        wrong = self._inspection.findings(
            state, self._now_ns, found, watch if pursuing else None, self._drive.lost
        )
        self._reversed = False
        events = self._judge(wrong, state, wanted, found.load_share) if wrong or response.reversing else ()
        if events and (self._state > SafetyState.ACTIVE or response.reversing):
            passes = False
            wanted = response.command(state, request.seq, powered=self._drive.powered)
            found = assess(state, wanted, self._cap())
        self._previous = wanted if passes else None
        self._drive.note(found.load_share)
        tau = self._act(state, found)
        return Outcome(
            self._applied,
            found.requested_tau_nm,
            tau,
            self._state,
            self._ramp.share,
            found.load_share,
            self._drive.powered,
            events,
            response.reversing,
            self._reversed,
        )

    def close(self) -> None:
        """Cut power and disconnect, at once. A hand that is held open snaps: see ``brake_and_close``."""
        if self._state is SafetyState.OFF:
            return
        self._drive.close()
        self._state = SafetyState.OFF

    def _cap(self) -> Float64:
        """Torque clamp of the present state: the motor's cap for damping, the patient's for all else."""
        envelope = self._inspection.envelope
        if self._state not in _GUIDED or self._response.reversing:
            return envelope.motor_cap_nm
        share = self._ramp.clamp
        return envelope.follow_cap_nm if share >= 1.0 else envelope.follow_cap_nm * share

    def _judge(
        self, found: list[Finding], state: DeviceState, wanted: DeviceCommand, load_share: float
    ) -> tuple[SafetyEvent, ...]:
        """Go back on a load, or enter the most severe state asked for, if it is more severe than this one."""
        if self._response.reversing:
            found = self._back_off(found, state, load_share)
        if not found:
            return ()
        worst = max(found, key=lambda finding: finding.state)
        if self._only_load(found) and self._response.go_back(state, wanted, self._applied):
            return (self._event(worst, "reversal"),)
        if worst.state > self._state:
            self._enter(worst, state)
            return (self._event(worst, worst.cause),)
        return tuple(
            self._event(finding, finding.cause) for finding in found if self._response.lower(finding.cause)
        )

    def _only_load(self, found: list[Finding]) -> bool:
        """Whether a load at full torque is all that is wrong, so that it may be gone back on."""
        alone = [finding.cause for finding in found] == ["load"]
        return alone and self._state is SafetyState.ACTIVE and self._ramp.clamp >= 1.0

    def _back_off(self, found: list[Finding], state: DeviceState, load_share: float) -> list[Finding]:
        """One tick of going back, which judges the load by itself meanwhile; what else is wrong."""
        stands = self._response.backing(state, load_share)
        if stands is Backing.FAILED:
            return [*found, self._inspection.envelope.load()]
        if stands is Backing.OVER:
            self._reversed = True
            self._ramp.begin_again()
        return [finding for finding in found if finding.cause != "load"]

    def _event(self, finding: Finding, cause: str) -> SafetyEvent:
        """What is reported of a finding that has changed something."""
        joint, value, bound = finding.joint, finding.value, finding.bound
        return SafetyEvent(self._now_ns, cause, self._state, joint, value, bound)

    def _enter(self, finding: Finding, state: DeviceState) -> None:
        """Enter a latched state."""
        self._state = finding.state
        self._response.enter(finding, state, self._applied)
        if finding.state is SafetyState.CAT1:
            self._drive.begin_brake()
        elif finding.state is SafetyState.CAT0:
            self._drive.cut_power()

    def _enter_ready(self) -> None:
        """READY: brake if there is power; no goal is left over."""
        self._state = SafetyState.READY
        self._ramp.begin()
        self._response.drop()
        self._previous, self._continued = None, False
        self._drive.brake_now()

    def _act(self, state: DeviceState, found: Assessment) -> Float64:
        """Give the device what the state allows and return the torque that it then applies, (J,)."""
        self._continued = False
        if not self._drive.powered:
            self._applied = nothing(len(self._names), found.applied.seq)
            return self._applied.tau_ff_nm
        self._applied = found.applied
        if self._state in (SafetyState.READY, SafetyState.CAT1):
            self._drive.settle(state, self._response.grip.common_nms_rad)
            return found.applied_tau_nm
        self._drive.send(found.applied)
        if self._state in _FOLLOWING:
            self._continued = True
            self._state = SafetyState.ACTIVE if self._ramp.advance() else SafetyState.RAMP_IN
        return found.applied_tau_nm
