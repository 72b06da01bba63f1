"""Going back on a load that opposes the motion: the one movement that the supervisor makes by itself."""

from __future__ import annotations

from enum import Enum

import numpy as np

from robot_iface.safety.grip import Grip
from robot_iface.types import CommandMode, DeviceCommand, DeviceState, Float64, Limits

BACK_RAD = float(np.deg2rad(10.0))
BACK_RAD_S = float(np.deg2rad(15.0))
FALLEN_SHARE = 0.8
"""Below this share of its limit a load has fallen."""
FALLS_WITHIN_S = 0.2
FALLEN_FOR_S = 0.01
MOVES_RAD_S = float(np.deg2rad(1.0))
_LEAD_SHARE = 0.5
_FOLLOWED_RAD_S = float(np.deg2rad(5.0))
_OPPOSED_SHARE = 0.5
_ROUNDING_S = 1e-9


class Backing(Enum):
    """How a reversal stands."""

    GOING = "going"
    OVER = "over"
    FAILED = "failed"


def opposes_motion(state: DeviceState, commanded_rad_s: Float64, limits: Limits) -> bool:
    """Whether every joint over its limit is loaded against a commanded motion: only then is it gone back on.

    The device pushes such a joint the way that it is told to move (tau_interaction times commanded speed is
    positive), so it is the patient who opposes. Where the patient drives with the motion, or nothing is meant
    to move, going back would fight the patient.

    Args:
        state: Newest reading.
        commanded_rad_s: Commanded speeds, (J,).
        limits: Limits of the driven joints.
    """
    over = np.abs(state.tau_interaction_nm) > limits.tau_interaction_nm
    against = state.tau_interaction_nm * commanded_rad_s > 0.0
    moving = np.abs(commanded_rad_s) > MOVES_RAD_S
    return bool(over.any() and (against & moving)[over].all())


class Reversal:
    """Retraces the commanded motion by 10 degrees of its fastest joint at 15 deg/s, from where the hand is.

    The spring that held the load is let go at once; what leads back is a new one that never carries more than
    half the limit, in a strong damping that also brakes whatever drives the hand. Where the hand goes back by
    itself, or against the way back, the goal goes with it: nothing but damping then acts on it.

    Args:
        state: Reading of the tick in which it begins.
        applied: Last applied command.
        commanded_rad_s: Commanded speeds, at least one of them above MOVES_RAD_S, (J,).
        limits: Limits of the driven joints.
        period_s: Control period.
    """

    def __init__(
        self,
        state: DeviceState,
        applied: DeviceCommand,
        commanded_rad_s: Float64,
        limits: Limits,
        period_s: float,
    ) -> None:
        self._period_s = period_s
        self._limit_nm = limits.tau_interaction_nm
        self._stiffness: Float64 = applied.stiffness_nm_rad
        self._speed: Float64 = commanded_rad_s * (-BACK_RAD_S / float(np.abs(commanded_rad_s).max()))
        self._way: Float64 = np.sign(self._speed)
        self._lead: Float64 = _LEAD_SHARE * self._limit_nm / np.maximum(self._stiffness, 1e-9)
        self._goal: Float64 = state.q_rad.copy()
        self._elapsed_s = 0.0
        self._low_s = 0.0
        self._fallen = False

    def command(self, state: DeviceState, grip: Grip, seq: int) -> DeviceCommand:
        """The command of this tick."""
        error = self._goal - state.q_rad
        least = np.where(self._way == 0.0, -self._lead, 0.0)
        along = np.minimum(np.maximum(np.where(self._way < 0.0, -error, error), least), self._lead)
        follows = state.dq_rad_s * self._way < -_FOLLOWED_RAD_S
        error = np.where(follows, 0.0, np.where(self._way < 0.0, -along, along))
        self._goal = state.q_rad + error + self._speed * self._period_s
        zeros = np.zeros(error.size)
        return DeviceCommand(
            mode=CommandMode.IMPEDANCE,
            q_rad=state.q_rad + error,
            dq_rad_s=self._speed,
            tau_ff_nm=zeros,
            stiffness_nm_rad=self._stiffness,
            damping_nms_rad=grip.update(state, self._speed),
            seq=seq,
        )

    def update(self, state: DeviceState, load_share: float) -> Backing:
        """Take the load of one tick.

        It fails where the load has not fallen in 200 ms, comes again, or opposes the way back too.
        """
        self._elapsed_s += self._period_s
        self._low_s = self._low_s + self._period_s if load_share < FALLEN_SHARE else 0.0
        self._fallen = self._fallen or self._low_s >= FALLEN_FOR_S - _ROUNDING_S
        if not self._fallen and self._elapsed_s >= FALLS_WITHIN_S - _ROUNDING_S:
            return Backing.FAILED
        if self._fallen and (load_share > 1.0 or self._opposed(state)):
            return Backing.FAILED
        return Backing.OVER if self._elapsed_s >= BACK_RAD / BACK_RAD_S - _ROUNDING_S else Backing.GOING

    def _opposed(self, state: DeviceState) -> bool:
        """Whether a joint is loaded against the way back."""
        pushed = state.tau_interaction_nm * self._way
        return bool((pushed > _OPPOSED_SHARE * self._limit_nm).any())
