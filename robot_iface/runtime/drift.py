"""Whether the hand still lies in the device as it did: the posture in which it carries no load (hazard 7).

While the patient rests or is moved, load follows angle and speed, t = k (q - q0) + b w. A regression over the
time of one repetition gives q0, the neutral posture, in the device's angles, wherever the hand moved enough.
Tone changes k; a strap that slips moves q0. A hand that hardly moves while the patient is quiet leaves one
posture and one load; with the k of before they raise a suspicion, which a probe must confirm.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robot_iface.runtime.kernels import sum_up
from robot_iface.types import DeviceState, Float64

DRIFT_RAD = float(np.deg2rad(8.0))
_EVERY = 10
"""One in so many ticks is looked at."""
SURE_RAD = float(np.deg2rad(1.5))
"""A neutral posture whose standard error is larger says nothing."""
RELAXED_S = 1.0
"""The effort of a patient who has been told to relax has gone after this time."""
_LEAST = 20
_LEAST_NM_RAD = 5e-3
_SPREAD_RAD = float(np.deg2rad(0.5))


@dataclass(frozen=True, slots=True)
class Drift:
    """A joint whose neutral posture has moved.

    Attributes:
        joint: Its column.
        value_rad: By how much.
        confirmed: Whether the regression shows it twice; else it is a suspicion, and a probe is needed.
    """

    joint: int
    value_rad: float
    confirmed: bool


class NeutralDrift:
    """Neutral postures of each repetition against those of the first in which they could be told.

    Two repetitions in a row must agree: a spasm passes, a slipped strap stays.

    Args:
        joints: Number of driven joints J.
        period_s: Control period.
    """

    def __init__(self, joints: int, period_s: float) -> None:
        self._relaxed_ticks = round(RELAXED_S / period_s)
        self._quiet_ticks = self._relaxed_ticks
        self._sums: Float64 = np.zeros((10, joints))
        self._first_rad: Float64 = np.full(joints, np.nan)
        self._stiffness_nm_rad: Float64 = np.full(joints, np.nan)
        self._suspect: NDArray[np.bool_] = np.zeros(joints, dtype=np.bool_)
        still = np.zeros(joints)
        sum_up(self._sums, still, still, still)
        self._sums[:] = 0.0

    def watch(self, state: DeviceState, *, quiet: bool) -> None:
        """Take a tick; it counts where the patient has been ``quiet``, without effort on purpose, for 1 s."""
        if not quiet:
            self._quiet_ticks = 0
            return
        self._quiet_ticks += 1
        if self._quiet_ticks % _EVERY or self._quiet_ticks < self._relaxed_ticks:
            return
        sum_up(self._sums, state.q_rad, state.dq_rad_s, state.tau_interaction_nm)

    def judge(self) -> Drift | None:
        """Close a repetition: the joint whose neutral has moved too far and most, None if none has."""
        neutral, stiffness = self.regression()
        guess = self._guess()
        self._sums[:] = 0.0
        known = np.isfinite(neutral)
        self._stiffness_nm_rad = np.where(known, stiffness, self._stiffness_nm_rad)
        self._first_rad = np.where(np.isfinite(self._first_rad), self._first_rad, neutral)
        moved = np.abs(np.where(known, neutral, guess) - self._first_rad)
        judged = np.isfinite(moved)
        far = judged & (np.where(judged, moved, 0.0) > DRIFT_RAD)
        confirmed = far & known & self._suspect
        self._suspect = np.where(judged, far, self._suspect)
        shown = confirmed if bool(confirmed.any()) else far & ~known
        if not bool(shown.any()):
            return None
        joint = int(np.argmax(np.where(shown, moved, -1.0)))
        return Drift(joint, float(moved[joint]), bool(confirmed[joint]))

    def regression(self) -> tuple[Float64, Float64]:
        """Neutral posture and stiffness by what was noted since the last judgement, (J,) each.

        NaN where the hand did not move enough, or something else than its passive joints moved it.
        """
        n, q, w, t, qq, qw, ww, qt, wt, tt = self._sums
        nothing = np.full(n.size, np.nan)
        if n[0] < _LEAST:
            return nothing, nothing
        with np.errstate(all="ignore"):
            mq, mw, mt = q / n, w / n, t / n
            sqq, sqw, sww = qq / n - mq * mq, qw / n - mq * mw, ww / n - mw * mw
            sqt, swt, stt = qt / n - mq * mt, wt / n - mw * mt, tt / n - mt * mt
            determinant = sqq * sww - sqw * sqw
            k = (sqt * sww - swt * sqw) / determinant
            b = (swt * sqq - sqt * sqw) / determinant
            left = np.maximum(stt - k * sqt - b * swt, 0.0)
            neutral = mq - (mt - b * mw) / k
            # Error of the intercept where the line meets zero load, residuals correlated over the whole time.
            error = np.sqrt(left * (1.0 + (neutral - mq) ** 2 / sqq)) / np.abs(k)
            sure = (k > _LEAST_NM_RAD) & (sqq > _SPREAD_RAD**2) & (error < SURE_RAD)
        return np.where(sure, neutral, np.nan), np.where(sure, k, np.nan)

    def _guess(self) -> Float64:
        """Neutral posture by the mean posture and load and the stiffness of before, (J,)."""
        n, q, _, t = self._sums[:4]
        if n[0] < _LEAST:
            return np.full(n.size, np.nan)
        return (q - t / self._stiffness_nm_rad) / n
