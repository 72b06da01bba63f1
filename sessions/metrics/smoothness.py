"""Smoothness of a speed profile: SPARC and log dimensionless jerk.

SPARC: Balasubramanian et al. 2015, doi 10.1186/s12984-015-0090-9. LDLJ of a *speed* profile carries T^3.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import numpy as np
from scipy.signal import ZoomFFT

from sessions.metrics.metric import Estimate
from sessions.records.fields import Float64, Int64

SPARC_CUT_HZ = 10.0
SPARC_THRESHOLD = 0.05
SPARC_PADDING = 4
SHORTEST = 8
"""Fewest samples of a profile."""
_TOGETHER = 64  # profiles whose spectra are held at once: they stay in the processor's cache
_STEP = 32  # lengths are rounded up to it, so that few tables of waves serve all
_LARGEST_WAVES = 2**17  # values of a table of waves (1 MB); longer profiles take the chirp z
_TOO_SHORT = Estimate.missing(f"fewer than {SHORTEST} samples")
_GAP = Estimate.missing("the profile has a gap")
_NOTHING_MOVED = Estimate.missing("nothing moved")
_UNCHANGED = Estimate.missing("the speed does not change")


def sparc(speed: Float64, rate_hz: float) -> Estimate:
    """Spectral arc length; nearer to 0 is smoother.

    -integral_0^wc sqrt((1/wc)^2 + (d|V|/dw)^2) dw, with |V| the amplitude spectrum over its largest value, wc
    the highest frequency below 10 Hz at which |V| is still 0.05.

    Args:
        speed: Speed profile, shape (N,), any amplitude.
        rate_hz: Samples per second.
    """
    return sparc_many([speed], rate_hz)[0]


def sparc_many(speeds: Sequence[Float64], rate_hz: float) -> list[Estimate]:
    """Spectral arc length of many profiles; those whose spectra are equally long are transformed together.

    Args:
        speeds: Profiles, each (N,) of its own length.
        rate_hz: Samples per second of all of them.
    """
    lengths = np.array([speed.size for speed in speeds], dtype=np.int64)
    found = [_TOO_SHORT] * len(speeds)
    long_enough = np.flatnonzero(lengths >= SHORTEST)
    sizes = 2 ** (np.ceil(np.log2(np.maximum(lengths, 1))).astype(np.int64) + SPARC_PADDING)
    for size in np.unique(sizes[long_enough]):
        rows = long_enough[sizes[long_enough] == size]
        for first in range(0, len(rows), _TOGETHER):
            chosen = rows[first : first + _TOGETHER]
            table, largest = _table([speeds[index] for index in chosen], lengths[chosen])
            arcs = _arc_lengths(table, int(size), rate_hz)
            for index, peak, arc in zip(chosen.tolist(), largest.tolist(), arcs.tolist(), strict=True):
                found[index] = _judged(peak, arc)
    return found


def _table(speeds: list[Float64], lengths: Int64) -> tuple[Float64, Float64]:
    """Profiles as rows padded with zeros, (R, N), and the largest value of each, NaN where there is a gap."""
    table = np.zeros((len(speeds), int(lengths.max())))
    table[np.arange(table.shape[1]) < lengths[:, None]] = np.concatenate(speeds)
    return table, table.max(axis=1)


def _arc_lengths(table: Float64, size: int, rate_hz: float) -> Float64:
    """Arc lengths of profiles (R, N) whose spectra have ``size`` lines, (R,); not finite where none is."""
    lines = min(math.floor(SPARC_CUT_HZ * size / rate_hz + 1e-9) + 1, size // 2 + 1)
    with np.errstate(invalid="ignore", divide="ignore"):
        spectrum = _amplitudes(table, size, lines)
        spectrum /= spectrum.max(axis=1, keepdims=True)
        above = spectrum >= SPARC_THRESHOLD
        first = above.argmax(axis=1)
        last = lines - 1 - above[:, ::-1].argmax(axis=1)
        rises = spectrum[:, 1:] - spectrum[:, :-1]
        arcs = np.sqrt(rises * rises + 1.0 / ((last - first) ** 2.0)[:, None])
    column = np.arange(lines - 1)
    inside = (column >= first[:, None]) & (column < last[:, None])
    return np.sum(arcs, axis=1, where=inside)


def _amplitudes(table: Float64, size: int, lines: int) -> Float64:
    """The first lines of the amplitude spectra of profiles (R, N) padded to ``size``, shape (R, lines).

    Few lines of a short profile are quicker summed than transformed: about the middle of the table the even
    part meets cosines only and the odd part sines only, and a shift in time leaves amplitudes alone. Longer
    ones are transformed into the lines that count only (chirp z).
    """
    half = -(-table.shape[1] // _STEP) * _STEP // 2
    padded = np.zeros((len(table), 2 * half))
    padded[:, : table.shape[1]] = table
    if half * lines > _LARGEST_WAVES:
        whole: Any = _zoom(2 * half, size, lines)(padded, axis=1)
        amplitudes: Float64 = np.abs(whole)
        return amplitudes
    late, early = padded[:, half:], padded[:, half - 1 :: -1]
    cosine, sine = _waves(half, size, lines)
    real, imaginary = (late + early) @ cosine, (late - early) @ sine
    real *= real
    imaginary *= imaginary
    real += imaginary
    return np.sqrt(real, out=real)


@lru_cache(maxsize=32)
def _zoom(number: int, size: int, lines: int) -> Any:
    """The transform of profiles of that length into the first lines of a spectrum of ``size``."""
    return ZoomFFT(number, [0.0, 2.0 * (lines - 1) / size], m=lines, endpoint=True)


@lru_cache(maxsize=32)
def _waves(half: int, size: int, lines: int) -> tuple[Float64, Float64]:
    """Cosines and sines of every line at half-sample times, each (half, lines)."""
    turns = 2.0 * np.pi / size * (np.arange(half) + 0.5)[:, None] * np.arange(lines)
    return np.cos(turns), np.sin(turns)


def _judged(peak: float, arc: float) -> Estimate:
    if not math.isfinite(peak):
        return _GAP
    if not peak > 0.0:
        return _NOTHING_MOVED
    return Estimate(-arc) if math.isfinite(arc) and arc > 0.0 else _UNCHANGED


def ldlj(speed: Float64, rate_hz: float) -> Estimate:
    """Log dimensionless jerk of a speed profile; nearer to 0 is smoother.

    -ln[(T^3 / V^2) integral |v''|^2 dt], T the duration and V the peak.

    Args:
        speed: Speed profile, shape (N,), any amplitude.
        rate_hz: Samples per second.
    """
    return ldlj_many([speed], rate_hz)[0]


def ldlj_many(speeds: Sequence[Float64], rate_hz: float) -> list[Estimate]:
    """Log dimensionless jerk of many profiles, taken together.

    Args:
        speeds: Profiles, each (N,) of its own length.
        rate_hz: Samples per second of all of them.
    """
    lengths = np.array([speed.size for speed in speeds], dtype=np.int64)
    found = [_TOO_SHORT] * len(speeds)
    chosen = np.flatnonzero(lengths >= SHORTEST)
    if not chosen.size:
        return found
    laid, size = np.concatenate([speeds[index] for index in chosen.tolist()]), lengths[chosen]
    first = np.cumsum(size) - size
    bends = np.zeros(laid.size)
    bends[:-2] = np.diff(laid, 2) ** 2
    bends[np.concatenate((first + size - 2, first + size - 1))] = 0.0  # these reach into the next profile
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        largest = np.maximum.reduceat(laid, first)
        cost = (size / rate_hz) ** 3 / largest**2 * np.add.reduceat(bends, first) * rate_hz**3
    for index, peak, one in zip(chosen.tolist(), largest.tolist(), cost.tolist(), strict=True):
        found[index] = _judged_cost(peak, one)
    return found


def _judged_cost(peak: float, cost: float) -> Estimate:
    if not math.isfinite(peak):
        return _GAP
    if not peak > 0.0:
        return _NOTHING_MOVED
    return Estimate(-math.log(cost)) if math.isfinite(cost) and cost > 0.0 else _UNCHANGED
