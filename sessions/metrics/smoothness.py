"""Smoothness of a speed profile: SPARC and log dimensionless jerk.

SPARC: Balasubramanian et al. 2015, doi 10.1186/s12984-015-0090-9. LDLJ of a *speed* profile carries T^3.
"""

from __future__ import annotations

import math

import numpy as np

from sessions.metrics.metric import Estimate
from sessions.records.fields import Float64

SPARC_CUT_HZ = 10.0
SPARC_THRESHOLD = 0.05
SPARC_PADDING = 4
SHORTEST = 8
"""Fewest samples of a profile."""


def sparc(speed: Float64, rate_hz: float) -> Estimate:
    """Spectral arc length; nearer to 0 is smoother.

    -integral_0^wc sqrt((1/wc)^2 + (d|V|/dw)^2) dw, with |V| the amplitude spectrum over its largest value, wc
    the highest frequency below 10 Hz at which |V| is still 0.05.

    Args:
        speed: Speed profile, shape (N,), any amplitude.
        rate_hz: Samples per second.
    """
    reason = _why_not(speed)
    if reason:
        return Estimate.missing(reason)
    size = 2 ** (math.ceil(math.log2(speed.size)) + SPARC_PADDING)
    frequency_hz = np.arange(size) * (rate_hz / size)
    spectrum = np.abs(np.fft.fft(speed, size))
    spectrum /= spectrum.max()
    below = frequency_hz <= SPARC_CUT_HZ
    frequency_hz, spectrum = frequency_hz[below], spectrum[below]
    above = np.flatnonzero(spectrum >= SPARC_THRESHOLD)
    chosen = slice(int(above[0]), int(above[-1]) + 1)
    frequency_hz, spectrum = frequency_hz[chosen], spectrum[chosen]
    if frequency_hz.size < 2:
        return Estimate.missing("the speed does not change")
    along = np.diff(frequency_hz) / (frequency_hz[-1] - frequency_hz[0])
    return Estimate(-float(np.sum(np.hypot(along, np.diff(spectrum)))))


def ldlj(speed: Float64, rate_hz: float) -> Estimate:
    """Log dimensionless jerk of a speed profile; nearer to 0 is smoother.

    -ln[(T^3 / V^2) integral |v''|^2 dt], T the duration and V the peak.

    Args:
        speed: Speed profile, shape (N,), any amplitude.
        rate_hz: Samples per second.
    """
    reason = _why_not(speed)
    if reason:
        return Estimate.missing(reason)
    step_s = 1.0 / rate_hz
    jerk = np.diff(speed, 2) / step_s**2
    duration_s = speed.size * step_s
    cost = duration_s**3 / float(speed.max()) ** 2 * float(np.sum(jerk**2)) * step_s
    return Estimate(-math.log(cost)) if cost > 0 else Estimate.missing("the speed does not change")


def _why_not(speed: Float64) -> str:
    if speed.size < SHORTEST:
        return f"fewer than {SHORTEST} samples"
    if not bool(np.isfinite(speed).all()):
        return "the profile has a gap"
    return "" if float(speed.max()) > 0 else "nothing moved"
