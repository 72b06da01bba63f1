"""What the supervisor itself wants of the hand in the states in which requests do not pass."""

from __future__ import annotations

from robot_iface.safety.reversal import Backing, Reversal, opposes_motion
from robot_iface.safety.yielding import ONSET_S, Holding, damped, nothing, onset
from robot_iface.types import DeviceCommand, DeviceState, Limits

LOWERED_AT_ONCE = frozenset({"pain", "held-stretch", "repetition-time-out"})


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
        self._yielding_s = 0.0

    @property
    def reversing(self) -> bool:
        """Whether a load is being gone back on."""
        return self._reversal is not None

    def command(self, state: DeviceState, seq: int, *, powered: bool) -> DeviceCommand:
        """The command of this tick: of the reversal or the hold that was begun, else damping."""
        if self._reversal is not None:
            return self._reversal.command(state, seq)
        if self._holding is not None:
            return self._holding.command(state, seq)
        if not powered:
            return nothing(self._joints, seq)
        self._yielding_s += self._period_s
        return damped(self._joints, onset(self._yielding_s), seq)

    def drop(self) -> None:
        """Neither hold nor go back any more."""
        self._yielding_s = 0.0 if self._reversal is None else ONSET_S
        self._holding = self._reversal = None

    def hold(self, applied: DeviceCommand, cause: str) -> None:
        """Begin to hold what is applied; for some causes, to lower it at once."""
        self._holding = Holding(applied, self._limits.tau_interaction_nm, self._period_s)
        self._holding.lowering = cause in LOWERED_AT_ONCE

    def lower(self, cause: str) -> bool:
        """Begin to lower what is held, if this is a cause to; whether that is new."""
        holding = self._holding
        if holding is None or holding.lowering or cause not in LOWERED_AT_ONCE:
            return False
        holding.lowering = True
        return True

    def go_back(self, state: DeviceState, wanted: DeviceCommand, applied: DeviceCommand) -> bool:
        """Begin to go back if the load opposes the motion; whether that was begun."""
        if self._reversal is not None or not opposes_motion(state, wanted.dq_rad_s, self._limits):
            return False
        self._reversal = Reversal(state, applied, wanted.dq_rad_s, self._limits, self._period_s)
        return True

    def backing(self, state: DeviceState, load_share: float) -> Backing | None:
        """One tick of going back, None while that is not done; it ends here when it is over."""
        if self._reversal is None:
            return None
        stands = self._reversal.update(state, load_share)
        if stands is Backing.OVER:
            self._reversal = None
        return stands
