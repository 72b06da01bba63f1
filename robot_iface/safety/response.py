"""What the supervisor itself wants of the hand in the states in which requests do not pass."""

from __future__ import annotations

from robot_iface.safety.envelope import Finding
from robot_iface.safety.grip import Grip, drives
from robot_iface.safety.reversal import Backing, Reversal, opposes_motion
from robot_iface.safety.yielding import Holding, damped, nothing
from robot_iface.types import DeviceCommand, DeviceState, Limits, SafetyState

_LOADS = frozenset({"load", "load-hard"})
_TOO_FAST = "speed-trip"
_LOWERED_AT_ONCE = frozenset({"pain", "held-stretch", "repetition-time-out"})


class Response:
    """Holding, going back on a load, damping, or nothing.

    Args:
        limits: Limits of the driven joints.
        period_s: Control period.
    """

    def __init__(self, limits: Limits, period_s: float) -> None:
        self._limits = limits
        self._period_s = period_s
        self._joints = limits.q_min_rad.size
        self._holding: Holding | None = None
        self._reversal: Reversal | None = None
        self.grip = Grip(limits)
        """How hard it may brake."""

    @property
    def reversing(self) -> bool:
        """Whether a load is being gone back on."""
        return self._reversal is not None

    def command(self, state: DeviceState, seq: int, *, powered: bool) -> DeviceCommand:
        """The command of this tick: of the reversal or the hold that was begun, else damping."""
        if self._reversal is not None:
            return self._reversal.command(state, self.grip, seq)
        if self._holding is not None:
            return self._holding.command(state, seq)
        if not powered:
            return nothing(self._joints, seq)
        return damped(self.grip.update(state), seq)

    def enter(self, finding: Finding, state: DeviceState, applied: DeviceCommand) -> None:
        """Begin what a state asks for: to hold what is applied, to yield, or to brake.

        What the patient drives is braked without a blow, also where it becomes too fast. Whatever else is
        wrong, and a stop by a person, is met with all of the brake at once.
        """
        self._holding = self._reversal = None
        too_fast = finding.cause == _TOO_FAST
        if finding.cause in _LOADS or (too_fast and drives(state, self._limits.tau_interaction_nm)):
            self.grip.begin(applied)
        elif not too_fast:
            self.grip.drop()
        if finding.state is SafetyState.HOLD:
            self._holding = Holding(applied, self._limits.tau_interaction_nm, self._period_s)
            self._holding.lowering = finding.cause in _LOWERED_AT_ONCE

    def drop(self) -> None:
        """Nothing is held, gone back on or yielded to any more."""
        self._holding = self._reversal = None
        self.grip.drop()

    def lower(self, cause: str) -> bool:
        """Begin to lower what is held, if this is a cause to; whether that is new."""
        holding = self._holding
        if holding is None or holding.lowering or cause not in _LOWERED_AT_ONCE:
            return False
        holding.lowering = True
        return True

    def go_back(self, state: DeviceState, wanted: DeviceCommand, applied: DeviceCommand) -> bool:
        """Begin to go back if the load opposes the motion; whether that was begun."""
        if self._reversal is not None or not opposes_motion(state, wanted.dq_rad_s, self._limits):
            return False
        self.grip.begin(applied)
        self._reversal = Reversal(state, applied, wanted.dq_rad_s, self._limits, self._period_s)
        return True

    def backing(self, state: DeviceState, load_share: float) -> Backing | None:
        """One tick of going back, None while that is not done; it ends here when it is over."""
        if self._reversal is None:
            return None
        stands = self._reversal.update(state, load_share)
        if stands is Backing.OVER:
            self.drop()
        return stands
