"""Feed-forward torque that is learnt between repetitions, on the path coordinate."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.signal import butter, sosfiltfilt

from robot_iface.control.feedforward_kernels import collect, look_up
from robot_iface.types import Float64, Limits

LEARNING_RATE = 0.8
CUTOFF_HZ = 5.0
DISCARD_LOAD_SHARE = 0.8
WORSE, WORSE_RAD = 1.2, float(np.deg2rad(0.3))
"""A joint whose error has grown by this factor, and by more than this, learns anew, ..."""
SLOWER = 0.25
"""... at this share of its rate from then on."""
BOUND_SHARE = 0.5
"""The feed-forward is at most this share of the interaction limit."""
FADE_S = 0.4
"""Assistive: it rises from zero over this stretch of the path and falls to zero before its end (over a
quarter of a short path)."""
NEAR_LIMIT_RAD = float(np.deg2rad(3.0))
"""Within this distance of the end of its range a joint is pushed there less and less, and at the end not at
all."""
_STEP_S = 0.01
_MOVES_SHARE = 0.1


class FeedForward:
    """u_{i+1}(s) = f u_i(s) + 0.8 K LP_5Hz(e_i(s)), |u| <= half the interaction limit.

    Indexed on the path coordinate, so that a pause or another speed does not shift it. The 5 Hz low-pass
    runs forwards and backwards between repetitions, hence without lag. Everything learnt is thrown away
    after a reversal, pain, or a load above 80 % of the limit: what pushes that hard shall not be pushed
    harder. A joint that learning has made worse forgets and learns at a quarter of the rate: K may be less
    than was said (the fingertip law on a straight finger), or the hand another than before. The caller slews
    what ``torque`` gives.

    Args:
        duration_s: Length of the path.
        limits: Interaction limits and today's range.
        forgetting: f: 1 passive, 0.7-0.9 assistive (below 1, or the robot takes over from a slacking
            patient).
        headings_rad: Assistive: where the path goes, at equal steps over its length, (M, J). A joint that is
            ahead on its way then teaches nothing: running ahead is success, not a fault. Learnt from are
            joints that lag, and joints that the path leaves where they are. The torque is zero at both ends
            of the path, so that the start is the patient's own. None (passive): every error, everywhere.
        stiffness_share: Share of the stiffness given to ``learn`` that holds the hand in every direction, a
            number or (J,): ``learning_share``.
    """

    def __init__(
        self,
        duration_s: float,
        limits: Limits,
        forgetting: float,
        headings_rad: Float64 | None = None,
        stiffness_share: Float64 | float = 1.0,
    ) -> None:
        bins = int(np.ceil(duration_s / _STEP_S)) + 2
        joints = limits.tau_interaction_nm.size
        self._bound_nm: Float64 = BOUND_SHARE * limits.tau_interaction_nm
        self._ends_rad: Float64 = np.stack((limits.q_min_rad, limits.q_max_rad))
        self._forgetting = forgetting
        places_s: Float64 = np.arange(bins, dtype=np.float64) * _STEP_S
        self._headings: Float64 | None = None
        self._fade: Float64 = np.ones((bins, 1))
        if headings_rad is not None:
            self._headings = _at_bins(headings_rad, places_s / duration_s)
            self._fade = _fade(places_s, duration_s)[:, None]
        self._learnt_nm: Float64 = np.zeros((bins, joints))
        self._errors_rad: Float64 = np.zeros((bins, joints))
        self._counts: Float64 = np.zeros(bins)
        self._peak_load = 0.0
        self._rate: Float64 = LEARNING_RATE * stiffness_share * np.ones(joints)
        self._last_rad: Float64 = np.full(joints, np.inf)
        self.observe(0.0, self.torque(0.0, np.zeros(joints)), 0.0)  # compiles both
        self._counts[:] = 0.0

    def torque(self, path_s: float, q_rad: Float64) -> Float64:
        """Feed-forward torque at a path coordinate, (J,) Nm, linear between bins.

        Args:
            path_s: Path coordinate.
            q_rad: Measured angles, (J,): what pushes a joint towards an end of its range that it is near is
                reduced.
        """
        out: Float64 = np.empty(q_rad.size)
        look_up(self._learnt_nm, path_s / _STEP_S, q_rad, self._ends_rad, NEAR_LIMIT_RAD, out)
        return out

    def forget(self) -> None:
        """Throw away at once what was learnt, as after pain; the repetition goes on without it."""
        self._learnt_nm[:] = 0.0

    def observe(self, path_s: float, error_rad: Float64, load_share: float) -> None:
        """Note the tracking error q_d - q, (J,), and the load (``Outcome.load_share``) of one moving tick."""
        collect(self._errors_rad, self._counts, path_s / _STEP_S, error_rad)
        if load_share > self._peak_load:
            self._peak_load = load_share

    def learn(self, stiffness_nm_rad: Float64, path_speed: float, *, discard: bool = False) -> bool:
        """Close a repetition.

        Args:
            stiffness_nm_rad: K with which it was made, (J,).
            path_speed: Path speed at which it was made (sets the low-pass on the path coordinate).
            discard: A reversal or pain happened.

        Returns:
            Whether anything learnt was kept.
        """
        keep = not discard and self._peak_load <= DISCARD_LOAD_SHARE
        if not keep:
            self.forget()
        elif bool(self._counts.any()):
            error = self._mean_error()
            worse = self._worse(np.sqrt((error * error).mean(axis=0)))
            if self._headings is not None:
                error = _without_ahead(error, self._headings)
            error = _low_pass(error, path_speed / _STEP_S)
            updated = self._forgetting * self._learnt_nm + self._rate * stiffness_nm_rad * error
            bounded = np.clip(updated, -self._bound_nm, self._bound_nm)
            self._learnt_nm = np.where(worse, 0.0, self._fade * bounded)
        self._errors_rad[:] = 0.0
        self._counts[:] = 0.0
        self._peak_load = 0.0
        return keep

    def _worse(self, rms_rad: Float64) -> NDArray[np.bool_]:
        """Where the error, (J,), has grown since the last repetition that went well; slows down there."""
        worse = (rms_rad > WORSE * self._last_rad) & (rms_rad > self._last_rad + WORSE_RAD)
        self._rate = np.where(worse, SLOWER * self._rate, self._rate)
        self._last_rad = np.where(worse, self._last_rad, rms_rad)
        return worse

    def _mean_error(self) -> Float64:
        """Mean error of each bin, (bins, J); bins that no tick met are interpolated."""
        counts = self._counts
        seen = np.flatnonzero(counts)
        mean = self._errors_rad[seen] / counts[seen, None]
        places = np.arange(counts.size, dtype=np.float64)
        return np.stack([np.interp(places, seen, mean[:, joint]) for joint in range(mean.shape[1])], axis=1)


def _fade(places_s: Float64, duration_s: float) -> Float64:
    """Share allowed at path coordinates, (M,): 0 at both ends of the path, 1 between, smooth."""
    from_end_s: Float64 = np.minimum(places_s, duration_s - places_s)
    u: Float64 = np.clip(from_end_s / min(FADE_S, 0.25 * duration_s), 0.0, 1.0)
    return u * u * (3.0 - 2.0 * u)


def _at_bins(headings_rad: Float64, shares: Float64) -> Float64:
    """Headings at shares of the path, (M,) -> (M, J); where the path has come to rest, the last one holds."""
    rows = np.arange(len(headings_rad))
    last = np.maximum.accumulate(np.where(np.any(headings_rad != 0.0, axis=1), rows, 0))
    places = np.minimum(np.rint(shares * (len(headings_rad) - 1)).astype(np.int64), len(headings_rad) - 1)
    return headings_rad[last[places]]


def _without_ahead(error_rad: Float64, headings: Float64) -> Float64:
    """Errors q_d - q, (M, J), without those of joints that are ahead where the path, (M, J), takes them.

    A joint that moves by less than a tenth of the one that moves most is across the path, in proportion.
    """
    most = np.abs(headings).max(axis=1, keepdims=True)
    moves = np.minimum(np.abs(headings) / (_MOVES_SHARE * most + 1e-12), 1.0)
    ahead = error_rad * headings < 0.0
    return error_rad * (1.0 - moves * ahead)


def _low_pass(error_rad: Float64, rate_hz: float) -> Float64:
    """Zero-lag 5 Hz low-pass along the first axis; below 11 Hz the bins are as coarse as the filter."""
    if rate_hz <= 2.2 * CUTOFF_HZ:
        return error_rad
    sections: Any = butter(2, CUTOFF_HZ, fs=rate_hz, output="sos")
    padding = min(15, error_rad.shape[0] - 1)
    filtered: Float64 = sosfiltfilt(sections, error_rad, axis=0, padlen=padding)
    return filtered
