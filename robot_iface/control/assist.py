"""Assistance that falls as ability grows: stiffness per digit and direction, adapted between repetitions."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from robot_iface.types import DIGITS, Float64, Int64

KEEP = 0.8
RAISE_PER_RAD = 8.0
DEAD_BAND_RAD = float(np.deg2rad(3.0))
MIN_MULTIPLE, MAX_MULTIPLE = 0.1, 4.0
AHEAD_STOP_RAD = float(np.deg2rad(15.0))
SLOW_RAD_S = float(np.deg2rad(5.0))
BLOCKED_S = 0.3
BLOCKED_RISE_NM = 0.01
_EVERY = 10
_MOVING_RAD_S = 1e-3
_SLEW_PER_S = 3.0


def free_ahead(error_rad: Float64, dq_desired_rad_s: Float64) -> Float64:
    """Error without the part along the path by which the patient is ahead; beyond 15 deg ahead it comes back.

    Args:
        error_rad: q_d - q, (J,).
        dq_desired_rad_s: Desired velocity, which gives the direction of the path, (J,).
    """
    speed = math.sqrt(float(dq_desired_rad_s @ dq_desired_rad_s))
    if speed < _MOVING_RAD_S:
        return error_rad
    along = float(error_rad @ dq_desired_rad_s) / speed
    if along >= 0.0:
        return error_rad
    freed = max(along, -AHEAD_STOP_RAD)
    return error_rad - dq_desired_rad_s * (freed / speed)


class AssistAsNeeded:
    """Stiffness multiples K_{i+1} = clip(0.8 K_i + 8 max(0, e_i - 3 deg), 0.1, 4) per digit and direction.

    e_i is the largest mean error, over the joints of a digit, by which the hand was *behind* while moving
    in that direction. A blocked digit (measured below 5 deg/s for 0.3 s while it should move and the torque
    rises), a reversed or a painful repetition never raises assistance: contracture is not weakness.

    Args:
        joint_names: The J driven joints.
        initial: First multiple, clipped to 0.1-4.
        period_s: Control period.
    """

    def __init__(self, joint_names: tuple[str, ...], initial: float, period_s: float) -> None:
        joints = len(joint_names)
        self._digits: list[NDArray[np.bool_]] = [
            np.array([name.startswith(digit + "_") for name in joint_names], dtype=np.bool_)
            for digit in DIGITS
        ]
        start = min(max(initial, MIN_MULTIPLE), MAX_MULTIPLE)
        self._by_direction: Float64 = np.full((2, joints), start)
        self._present: Float64 = np.full(joints, start)
        self._slew = _SLEW_PER_S * period_s
        self._flexing = np.ones(joints, dtype=np.bool_)
        self._blocked_after = max(int(BLOCKED_S / (period_s * _EVERY)), 1)
        self._tick = 0
        self._clear()

    def multiple(self, dq_desired_rad_s: Float64) -> Float64:
        """Stiffness multiples for the direction of movement, (J,); once a tick, they slew by 3 per second."""
        self._tick += 1
        if self._tick % _EVERY == 1:
            self._flexing = np.where(
                np.abs(dq_desired_rad_s) < _MOVING_RAD_S, self._flexing, dq_desired_rad_s > 0.0
            )
            self._target = np.where(self._flexing, self._by_direction[1], self._by_direction[0])
        step = self._target - self._present
        self._present = self._present + np.minimum(np.maximum(step, -self._slew), self._slew)
        return self._present

    def by_direction(self) -> Float64:
        """Multiples into extension (row 0) and into flexion (row 1), (2, J)."""
        return self._by_direction.copy()

    def blocked(self) -> tuple[str, ...]:
        """Digits that were blocked in this repetition so far."""
        return tuple(
            digit
            for digit, columns in zip(DIGITS, self._digits, strict=True)
            if bool(self._was_blocked[:, columns].any())
        )

    def observe(
        self,
        dq_desired_rad_s: Float64,
        error_rad: Float64,
        dq_rad_s: Float64,
        tau_interaction_nm: Float64,
    ) -> None:
        """Note a moving tick (one in ten is used): desired speed, q_d - q, speed, load. Arrays (J,)."""
        if self._tick % _EVERY != 1:
            return
        moving = np.abs(dq_desired_rad_s) > _MOVING_RAD_S
        direction = np.sign(dq_desired_rad_s)
        behind = np.maximum(error_rad * direction, 0.0) * moving
        row = (dq_desired_rad_s > 0.0).astype(np.int64)
        columns = np.arange(row.size)
        self._sum_rad[row, columns] += behind
        self._counts[row, columns] += moving
        self._note_blocked(moving, direction, row, dq_desired_rad_s, dq_rad_s, tau_interaction_nm)

    def _note_blocked(
        self,
        moving: NDArray[np.bool_],
        direction: Float64,
        row: Int64,
        dq_desired_rad_s: Float64,
        dq_rad_s: Float64,
        tau_interaction_nm: Float64,
    ) -> None:
        """Count how long each joint stands still under a push that grows."""
        push = tau_interaction_nm * direction
        stuck = moving & (np.abs(dq_desired_rad_s) > SLOW_RAD_S) & (dq_rad_s * direction < SLOW_RAD_S)
        self._push_nm = np.where(self._stuck == 0, push, self._push_nm)
        self._stuck = np.where(stuck, self._stuck + 1, 0)
        hit = (self._stuck >= self._blocked_after) & (push > self._push_nm + BLOCKED_RISE_NM)
        self._was_blocked[row[hit], np.flatnonzero(hit)] = True

    def finish_repetition(self, *, reversed_on_load: bool = False, painful: bool = False) -> None:
        """Adapt for the next repetition."""
        mean = self._sum_rad / np.maximum(self._counts, 1)
        for columns in self._digits:
            if not bool(columns.any()):
                continue
            for row in range(2):
                old = self._by_direction[row, columns]
                excess = max(0.0, float(mean[row, columns].max()) - DEAD_BAND_RAD)
                new = np.clip(KEEP * old + RAISE_PER_RAD * excess, MIN_MULTIPLE, MAX_MULTIPLE)
                if reversed_on_load or painful or bool(self._was_blocked[row, columns].any()):
                    new = np.minimum(new, old)
                self._by_direction[row, columns] = new
        self._clear()

    def _clear(self) -> None:
        """Forget what was observed; the multiples stay."""
        joints = self._present.size
        self._target: Float64 = np.where(self._flexing, self._by_direction[1], self._by_direction[0])
        self._sum_rad: Float64 = np.zeros((2, joints))
        self._counts: Float64 = np.zeros((2, joints))
        self._stuck: Float64 = np.zeros(joints)
        self._push_nm: Float64 = np.zeros(joints)
        self._was_blocked = np.zeros((2, joints), dtype=np.bool_)
