"""The one low-pass filter of the package, and the speed that follows from it."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
from scipy import signal

from sessions.records.fields import Float64

CUT_HZ = 6.0
"""Voluntary finger movement lies below 5 Hz; 1 mm of noise at 30 Hz drowns an unfiltered log jerk."""
FILTER = "zero-phase Butterworth low-pass, order 4, 6 Hz"
_TWO_PASSES = (np.sqrt(2.0) - 1.0) ** 0.25
"""Two passes of an order-2 filter are 3 dB down at this share of its own cut (Winter, Biomechanics)."""


def cut_hz(rate_hz: float) -> float:
    """The cut that this sampling rate allows: 6 Hz, or 0.4 of the rate where that is lower."""
    return min(CUT_HZ, 0.4 * rate_hz * float(_TWO_PASSES))


def low_pass(values: Float64, rate_hz: float) -> Float64:
    """Filter along time, forward and back, so that nothing is delayed.

    Args:
        values: Uniform samples without gaps, shape (N, ...).
        rate_hz: Samples per second.
    """
    corner = cut_hz(rate_hz) / float(_TWO_PASSES)
    sections = _sections(corner, rate_hz)
    padding = min(len(values) - 1, round(1.5 * rate_hz))
    result: Float64 = signal.sosfiltfilt(sections, values, axis=0, padlen=padding)
    return result


@lru_cache(maxsize=64)
def _sections(corner_hz: float, rate_hz: float) -> Float64:
    """Second-order sections; finding them takes longer than filtering a stroke."""
    sections: Any = signal.butter(2, corner_hz, fs=rate_hz, output="sos")
    return np.asarray(sections, dtype=np.float64)


def speed_m_s(p_m: Float64, rate_hz: float) -> Float64:
    """Speed of a filtered path, shape (N,), from positions (N, 3), by central differences."""
    velocity: Float64 = np.gradient(p_m, 1.0 / rate_hz, axis=0)
    return np.linalg.norm(velocity, axis=1)
