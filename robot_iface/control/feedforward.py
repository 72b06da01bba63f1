"""Feed-forward torque that is learnt between repetitions, on the path coordinate."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.signal import butter, sosfiltfilt

from robot_iface.types import Float64

LEARNING_RATE = 0.8
CUTOFF_HZ = 5.0
DISCARD_LOAD_SHARE = 0.8
BOUND_SHARE = 0.5
"""The feed-forward is at most this share of the interaction limit."""
_STEP_S = 0.01


class FeedForward:
    """u_{i+1}(s) = f u_i(s) + 0.8 K LP(e_i(s)), |u| <= half the interaction limit.

    Indexed on the path coordinate, so that a pause or another speed does not shift it. The 5 Hz low-pass
    runs forwards and backwards between repetitions, hence without lag. Everything learnt is thrown away
    after a reversal, pain, or a load above 80 % of the limit: what pushes that hard shall not be pushed
    harder.

    Args:
        duration_s: Length of the path.
        tau_interaction_nm: Interaction limits, (J,).
        forgetting: f: 1 passive, 0.7-0.9 assistive (below 1, or the robot takes over from a slacking
            patient).
    """

    def __init__(self, duration_s: float, tau_interaction_nm: Float64, forgetting: float) -> None:
        bins = int(np.ceil(duration_s / _STEP_S)) + 2
        joints = tau_interaction_nm.size
        self._bound_nm: Float64 = BOUND_SHARE * tau_interaction_nm
        self._forgetting = forgetting
        self._last = bins - 2
        self._learnt_nm: Float64 = np.zeros((bins, joints))
        self._errors_rad: Float64 = np.zeros((bins, joints))
        self._counts: list[int] = [0] * bins
        self._peak_load = 0.0

    def torque(self, path_s: float) -> Float64:
        """Feed-forward torque at a path coordinate, (J,) Nm, linear between bins."""
        place = path_s / _STEP_S
        low = min(int(place), self._last)
        part = min(place - low, 1.0)
        return self._learnt_nm[low] * (1.0 - part) + self._learnt_nm[low + 1] * part

    def observe(self, path_s: float, error_rad: Float64, load_share: float) -> None:
        """Note the tracking error q_d - q, (J,), and the load (``Outcome.load_share``) of one moving tick."""
        place = min(int(path_s / _STEP_S + 0.5), self._last + 1)
        self._errors_rad[place] += error_rad
        self._counts[place] += 1
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
            self._learnt_nm[:] = 0.0
        elif any(self._counts):
            error = _low_pass(self._mean_error(), path_speed / _STEP_S)
            updated = self._forgetting * self._learnt_nm + LEARNING_RATE * stiffness_nm_rad * error
            self._learnt_nm = np.clip(updated, -self._bound_nm, self._bound_nm)
        self._errors_rad[:] = 0.0
        self._counts = [0] * len(self._counts)
        self._peak_load = 0.0
        return keep

    def _mean_error(self) -> Float64:
        """Mean error of each bin, (bins, J); bins that no tick met are interpolated."""
        counts = np.array(self._counts, dtype=np.float64)
        seen = np.flatnonzero(counts)
        mean = self._errors_rad[seen] / counts[seen, None]
        places = np.arange(counts.size, dtype=np.float64)
        return np.stack([np.interp(places, seen, mean[:, joint]) for joint in range(mean.shape[1])], axis=1)


def _low_pass(error_rad: Float64, rate_hz: float) -> Float64:
    """Zero-lag 5 Hz low-pass along the first axis; below 11 Hz the bins are as coarse as the filter."""
    if rate_hz <= 2.2 * CUTOFF_HZ:
        return error_rad
    sections: Any = butter(2, CUTOFF_HZ, fs=rate_hz, output="sos")
    padding = min(15, error_rad.shape[0] - 1)
    filtered: Float64 = sosfiltfilt(sections, error_rad, axis=0, padlen=padding)
    return filtered
