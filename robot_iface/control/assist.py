"""Assistance that falls as ability grows: stiffness per digit and direction, adapted between repetitions."""

from __future__ import annotations

import math
from typing import cast

import numpy as np

from robot_iface.control.assist_kernels import aim, note
from robot_iface.errors import Refused
from robot_iface.types import DIGITS, Float64, Int64

KEEP = 0.8
RAISE_PER_RAD = 8.0
DEAD_BAND_RAD = float(np.deg2rad(3.0))
MIN_MULTIPLE, MAX_MULTIPLE = 0.1, 4.0
AHEAD_STOP_RAD = float(np.deg2rad(15.0))
"""A patient may run ahead so far along the path; beyond, the set-point stays behind and holds back."""
SLOW_RAD_S = float(np.deg2rad(5.0))
MOVED_RAD = float(np.deg2rad(5.0))
"""A joint that the exercise moves by less is held: what it lacks to its place is posture, not weakness."""
BLOCKED_S = 0.3
BLOCKED_RISE_NM = 0.01
RAISED_BY = 1.1
"""Only stiffness that was raised by a tenth or more says how the hand answers."""
STIFF_ANSWER = 0.5
"""A hand opposes if its torque grows by more than this power of the stiffness: it is then stiffer than the
robot's spring, and pushing harder gains more load than movement."""
OPPOSING_NM = 0.02
"""Less mean torque is no opposition."""
RELAXED_SHARE = 0.7
"""The ceiling is lifted once the opposing torque is this share of what it was at that stiffness."""
_EVERY = 10
_MOVING_RAD_S = 1e-3
_SLEW_PER_S = 3.0


class AssistAsNeeded:
    """Stiffness multiples K_{i+1} = clip(0.8 K_i + 8 max(0, e_i - 3 deg), 0.1, 4) per digit and direction.

    e_i is the largest mean error, over the joints of a digit, by which the hand was *behind* while moving
    in that direction. A blocked digit (measured below 5 deg/s for 0.3 s while it should move and the torque
    rises), a reversed or a painful repetition never raises assistance: contracture is not weakness. If the
    torque that opposes the movement rises with K, K goes back to what it was, stays below that until the
    torque has fallen, and the patient is to be told to relax (``cue_relax``). A direction in which nothing
    moved keeps what it has; joints that the exercise hardly moves are not judged.

    Args:
        joint_names: The J driven joints.
        initial: First multiple, clipped to 0.1-4.
        period_s: Control period.
        by_digit: First multiples instead, as ``by_digit`` gives them; empty for none.
        span_rad: Range of each joint in the movement, (J,); None where all are moved.

    Raises:
        Refused: ``by_digit`` is not two rows of five.
    """

    def __init__(
        self,
        joint_names: tuple[str, ...],
        initial: float,
        period_s: float,
        by_digit: tuple[tuple[float, ...], ...] = (),
        span_rad: Float64 | None = None,
    ) -> None:
        digits = [DIGITS.index(name.split("_")[0]) for name in joint_names]
        self._digit: Int64 = np.array(digits, dtype=np.int64)
        self._present_digits = tuple(sorted(set(digits)))
        self._by_digit: Float64 = np.full((2, len(DIGITS)), initial)
        if by_digit:
            if [len(row) for row in by_digit] != [len(DIGITS)] * 2:
                raise Refused("assistance", "of another form", "2 rows of 5", "begin without it")
            self._by_digit = np.array(by_digit, dtype=np.float64)
        np.clip(self._by_digit, MIN_MULTIPLE, MAX_MULTIPLE, out=self._by_digit)
        joints = len(joint_names)
        moved = np.ones(joints) if span_rad is None else (span_rad >= MOVED_RAD).astype(np.float64)
        self._moved: Float64 = moved
        self._slew = _SLEW_PER_S * period_s
        self._blocked_after = float(max(int(BLOCKED_S / (period_s * _EVERY)), 1))
        self._raised_from: Float64 = np.full_like(self._by_digit, math.nan)
        self._last_push_nm: Float64 = np.zeros_like(self._by_digit)
        self._ceiling: Float64 = np.full_like(self._by_digit, MAX_MULTIPLE)
        self._ceiling_push_nm: Float64 = np.zeros_like(self._by_digit)
        self._relax: tuple[str, ...] = ()
        self._tick = 0
        # present multiple, its target, whether flexing; then sums of error and push, counts, blocked by row
        self._now: Float64 = np.ones((3, joints))
        self._seen: Float64 = np.zeros((4, 2, joints))
        self._stuck: Float64 = np.zeros((2, joints))
        self._compile(np.zeros(joints))
        self._expand()
        self._now[0] = self._now[1]

    def _compile(self, still: Float64) -> None:
        """Call everything once before the first tick."""
        self.multiple(still)
        self.observe(still, still, still, still)
        self._tick = 0
        self._now[2] = 1.0
        self._clear()

    def multiple(self, dq_desired_rad_s: Float64) -> Float64:
        """Stiffness multiples for the direction of movement, (J,); once a tick, they slew by 3 per second."""
        self._tick += 1
        out: Float64 = np.empty(self._digit.size)
        turn = self._tick % _EVERY == 1
        aim(self._now, self._by_digit, self._digit, dq_desired_rad_s, turn, _MOVING_RAD_S, self._slew, out)
        return out

    def by_direction(self) -> Float64:
        """Multiples into extension (row 0) and into flexion (row 1), (2, J)."""
        return self._by_digit[:, self._digit]

    def by_digit(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Multiples into extension and into flexion in the order of DIGITS, as a session remembers them."""
        rows = cast("list[list[float]]", self._by_digit.tolist())
        return tuple(rows[0]), tuple(rows[1])

    @property
    def cue_relax(self) -> tuple[str, ...]:
        """Digits whose opposing torque rose with the help in the last repetition: the patient is to relax."""
        return self._relax

    def blocked(self) -> tuple[str, ...]:
        """Digits that were blocked in this repetition so far."""
        hit = self._seen[3].any(axis=0)
        return tuple(DIGITS[digit] for digit in self._present_digits if hit[self._digit == digit].any())

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
        bounds = (_MOVING_RAD_S, SLOW_RAD_S, self._blocked_after, BLOCKED_RISE_NM)
        wanted_rad_s = dq_desired_rad_s * self._moved
        note(wanted_rad_s, error_rad, dq_rad_s, tau_interaction_nm, self._seen, self._stuck, bounds)

    def finish_repetition(self, *, reversed_on_load: bool = False, painful: bool = False) -> None:
        """Adapt for the next repetition."""
        counts = np.maximum(self._seen[2], 1.0)
        behind, push = self._seen[0] / counts, self._seen[1] / counts
        held = reversed_on_load or painful
        relax: list[str] = []
        for digit in self._present_digits:
            columns = self._digit == digit
            for row in range(2):
                if not bool(self._seen[2, row, columns].any()):
                    continue
                excess = max(0.0, float(behind[row, columns].max()) - DEAD_BAND_RAD)
                blocked = bool(self._seen[3, row, columns].any())
                if self._adapt(row, digit, excess, float(push[row, columns].max()), held=held or blocked):
                    relax.append(DIGITS[digit])
        self._relax = tuple(dict.fromkeys(relax))
        self._clear()
        self._expand()

    def _adapt(self, row: int, digit: int, excess_rad: float, push_nm: float, *, held: bool) -> bool:
        """The next multiple of a digit in a direction; whether it opposes."""
        at = (row, digit)
        old, before = float(self._by_digit[at]), float(self._raised_from[at])
        new = min(max(KEEP * old + RAISE_PER_RAD * excess_rad, MIN_MULTIPLE), MAX_MULTIPLE)
        if held:
            new = min(new, old)
        last_nm = float(self._last_push_nm[at])
        opposes = self._opposes(old, before, last_nm, push_nm)
        if opposes:
            self._ceiling[at], self._ceiling_push_nm[at] = before, last_nm
        elif push_nm < RELAXED_SHARE * self._ceiling_push_nm[at]:
            self._ceiling[at] = MAX_MULTIPLE
        new = min(new, float(self._ceiling[at]))
        self._raised_from[at] = old if new > RAISED_BY * old else math.nan
        self._last_push_nm[at] = push_nm
        self._by_digit[at] = new
        return opposes

    @staticmethod
    def _opposes(now: float, before: float, push_before_nm: float, push_nm: float) -> bool:
        """Whether the opposing torque has risen with the stiffness, which was raised from ``before``."""
        if not now > RAISED_BY * before or push_nm < OPPOSING_NM:  # nan: it was not raised
            return False
        grown = push_nm / max(push_before_nm, 1e-6)
        return math.log(grown) > STIFF_ANSWER * math.log(now / before)

    def _expand(self) -> None:
        rows = np.where(self._now[2] > 0.5, 1, 0)
        self._now[1] = self._by_digit[rows, self._digit]

    def _clear(self) -> None:
        """Forget what was observed; the multiples stay."""
        self._seen[:] = 0.0
        self._stuck[:] = 0.0
