"""Rhythm of a repeated movement: decrement of its amplitude, and pauses within it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import stdtrit

from sessions.metrics.filtering import low_pass
from sessions.metrics.metric import Estimate
from sessions.metrics.spans import uniform_spans
from sessions.records.fields import Float64

FEWEST_STROKES = 6
"""Three repetitions: below that a trend is no trend."""
STILL_SHARE = 0.1
PAUSE_S = 0.5


@dataclass(frozen=True, slots=True)
class Pauses:
    """Rests between the first stroke and the last.

    Attributes:
        count: How many lasted half a second or more.
        longest: The longest stretch below a tenth of the peak speed, s.
    """

    count: Estimate
    longest: Estimate


def decrement(amplitude: Float64) -> Estimate:
    """Part of the first stroke's amplitude that is lost by the last, from a straight line through all.

    Args:
        amplitude: Amplitude of each stroke in order, shape (S,), any unit. The interval is that of the slope.
    """
    count = amplitude.size
    if count < FEWEST_STROKES:
        return Estimate.missing("fewer than three repetitions")
    at = np.arange(count) - 0.5 * (count - 1)
    slope = float(at @ amplitude / (at @ at))
    first = float(amplitude.mean()) + slope * float(at[0])
    if not first > 0.0:
        return Estimate.missing("the first stroke has no amplitude")
    rest = amplitude - amplitude.mean() - slope * at
    spread = float(np.sqrt(rest @ rest / (count - 2) / (at @ at)))
    half = float(stdtrit(count - 2, 0.975)) * spread * (count - 1) / first
    value = -slope * (count - 1) / first
    return Estimate(value, (value - half, value + half))


def pauses(t_s: Float64, movement: Float64, strokes_s: Float64) -> Pauses:
    """Rests within a repeated movement.

    Args:
        t_s: Times, shape (N,).
        movement: The main movement, shape (N,), NaN in gaps.
        strokes_s: Start and end of each stroke, shape (S, 2).
    """
    if len(strokes_s) < 2:
        missing = Estimate.missing("fewer than two strokes")
        return Pauses(missing, missing)
    still: list[float] = []
    spans = uniform_spans(t_s, movement)
    speeds = [np.abs(np.gradient(low_pass(span.values, span.rate_hz))) * span.rate_hz for span in spans]
    peak = max((float(speed.max()) for speed in speeds), default=0.0)
    for span, speed in zip(spans, speeds, strict=True):
        inside = (span.t_s >= strokes_s[0, 0]) & (span.t_s <= strokes_s[-1, 1])
        still += _runs_s((speed < STILL_SHARE * peak) & inside, span.rate_hz)
    longest = max(still, default=0.0)
    return Pauses(
        Estimate(float(sum(length >= PAUSE_S for length in still))),
        Estimate(longest, None, "no interval: it hangs on a threshold of the speed"),
    )


def _runs_s(rows: np.ndarray[tuple[int, ...], np.dtype[np.bool_]], rate_hz: float) -> list[float]:
    edges = np.flatnonzero(np.diff(np.concatenate(([0], rows.astype(np.int8), [0]))))
    return [float(length) / rate_hz for length in (edges[1::2] - edges[::2])]
