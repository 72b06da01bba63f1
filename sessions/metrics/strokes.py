"""Fingertip numbers that belong to single strokes, brought together over the strokes of a recording."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.special import stdtrit

from sessions.metrics.filtering import low_pass, speed_m_s
from sessions.metrics.metric import Estimate
from sessions.metrics.movement import active_rows, path_ratio, peak_speed, time_of
from sessions.metrics.smoothness import ldlj_many, sparc_many
from sessions.metrics.spans import uniform_spans
from sessions.records.fields import Float64

Reach = tuple[float, float]
FEWEST_FOR_INTERVAL = 3
NOISE_SPEEDS = 7.0
"""The hand moves where its speed is more than so many times what noise alone makes of it per axis, root mean
square. Noise is stated by its median size; its tail is some three times as large (``stroke_noise``)."""
CLEAR_OF_NOISE = 2.0
"""A stroke whose peak is less than so many times that speed is drowned: most of it cannot be seen."""
NO_STROKE = "no gap-free stroke of 5 mm or more, clear of the noise"
SMALLEST_STROKE_M = 0.005
"""Fingertips that travel less than this in a stroke did not take part in it."""


@dataclass(frozen=True, slots=True)
class StrokeValues:
    """The numbers of one fingertip in one stroke.

    Attributes:
        sparc: Spectral arc length.
        ldlj: Log dimensionless jerk.
        movement_time: Onset to offset, s.
        peak_speed: Highest speed, m/s.
        path_ratio: Path over chord.
        chord_m: Distance of the stroke's ends, m.
        reach_m: Largest distance from the stroke's beginning, m.
        window_s: From one turning point to the next, with the rest about the movement, s.
        rate_hz: Samples per second.
    """

    sparc: Estimate
    ldlj: Estimate
    movement_time: Estimate
    peak_speed: Estimate
    path_ratio: Estimate
    chord_m: float
    reach_m: float
    window_s: float
    rate_hz: float


def stroke_values(t_s: Float64, p_m: Float64, strokes_s: Float64, noise_m: float = 0.0) -> list[StrokeValues]:
    """Numbers of every stroke that the fingertip made without a gap.

    Args:
        t_s: Times, shape (N,).
        p_m: Fingertip in the palm frame, shape (N, 3), NaN in gaps.
        strokes_s: Start and end of each stroke, shape (S, 2).
        noise_m: Standard deviation of the fingertip per axis, from frame to frame; NaN counts as none.
    """
    found: list[StrokeValues] = []
    for span in uniform_spans(t_s, p_m):
        smooth = low_pass(span.values, span.rate_hz)
        step = 0.5 / span.rate_hz
        pieces: list[Float64] = []
        for start, end in strokes_s:
            if start < span.t_s[0] - step or end > span.t_s[-1] + step:
                continue
            rows = slice(*np.searchsorted(span.t_s, (start - step, end + step)).tolist())
            pieces.append(smooth[rows])
        found += of_many(pieces, span.rate_hz, noise_m if math.isfinite(noise_m) else 0.0)
    return found


def over_strokes(values: Sequence[Estimate], reach: Reach = (0.0, 0.0)) -> Estimate:
    """Mean over strokes; the interval is the t-interval of that mean, from three strokes on.

    Args:
        values: One estimate per stroke; those without a value take no part.
        reach: How far the measurement moves them, measured less true, least and most.
    """
    known = np.array([item.value for item in values if math.isfinite(item.value)])
    if not known.size:
        return Estimate.missing(values[0].reason if values else NO_STROKE)
    mean = float(known.mean())
    if known.size < FEWEST_FOR_INTERVAL:
        return Estimate(mean, None, f"no interval: {known.size} of at least {FEWEST_FOR_INTERVAL}")
    half = float(stdtrit(known.size - 1, 0.975)) * float(known.std(ddof=1)) / math.sqrt(known.size)
    return Estimate(mean, (mean - reach[1] - half, mean - reach[0] + half))


@lru_cache(maxsize=256)
def _noise_gain(rate_hz: float) -> float:
    """Speed, 1/s, that white noise of size 1 has per axis behind filter and differences, root mean square."""
    impulse = np.zeros((4 * max(round(rate_hz), 8) + 1, 1))
    impulse[len(impulse) // 2] = 1.0
    return float(np.linalg.norm(speed_m_s(low_pass(impulse, rate_hz), rate_hz)))


def noise_speed_m_s(noise_m: float, rate_hz: float) -> float:
    """Speed below which noise alone may be seen.

    Args:
        noise_m: Standard deviation per axis, from frame to frame.
        rate_hz: Samples per second.
    """
    return NOISE_SPEEDS * noise_m * _noise_gain(round(rate_hz, 2))


def of_many(paths_m: Sequence[Float64], rate_hz: float, noise_m: float) -> list[StrokeValues]:
    """Numbers of filtered strokes (N, 3) that went far and fast enough; spectra are transformed together.

    Args:
        paths_m: The strokes.
        rate_hz: Samples per second.
        noise_m: Standard deviation of the unfiltered fingertip per axis.
    """
    paths = [
        path
        for path in paths_m
        if len(path) >= 2 and float(np.linalg.norm(np.ptp(path, axis=0))) >= SMALLEST_STROKE_M
    ]
    speeds = [speed_m_s(path, rate_hz) for path in paths]
    still_m_s = noise_speed_m_s(noise_m, rate_hz)
    kept = [index for index, speed in enumerate(speeds) if float(speed.max()) > CLEAR_OF_NOISE * still_m_s]
    rows = {index: active_rows(speeds[index], still_m_s) for index in kept}
    profiles = [speeds[index][rows[index]] for index in kept]
    smooth, jerky = sparc_many(profiles, rate_hz), ldlj_many(profiles, rate_hz)
    return [
        _values(paths[index], speeds[index], rows[index], rate_hz, arc, jerk)
        for index, arc, jerk in zip(kept, smooth, jerky, strict=True)
    ]


def _values(
    path: Float64, speed: Float64, used: slice, rate_hz: float, arc: Estimate, jerk: Estimate
) -> StrokeValues:
    moved = path[used] - path[used.start]
    return StrokeValues(
        arc,
        jerk,
        time_of(used, rate_hz),
        peak_speed(speed),
        path_ratio(path[used]),
        chord_m=float(np.linalg.norm(moved[-1])),
        reach_m=float(np.linalg.norm(moved, axis=1).max()),
        window_s=(len(path) - 1) / rate_hz,
        rate_hz=rate_hz,
    )
