"""Fingertip numbers that belong to single strokes, brought together over the strokes of a recording."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.special import stdtrit

from sessions.metrics.filtering import low_pass, speed_m_s
from sessions.metrics.metric import Estimate
from sessions.metrics.movement import active_rows, path_ratio, peak_speed, time_of
from sessions.metrics.smoothness import ldlj_many, sparc_many
from sessions.metrics.spans import uniform_spans
from sessions.records.fields import Float64

FEWEST_FOR_INTERVAL = 3
FLOOR_DRAWS = 20
ONSET_TO_OFFSET = 0.8811
"""Part of a minimum-jerk stroke in which its speed lies above a twentieth of its peak."""
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
        rate_hz: Samples per second.
    """

    sparc: Estimate
    ldlj: Estimate
    movement_time: Estimate
    peak_speed: Estimate
    path_ratio: Estimate
    chord_m: float
    rate_hz: float


def stroke_values(t_s: Float64, p_m: Float64, strokes_s: Float64) -> list[StrokeValues]:
    """Numbers of every stroke that the fingertip made without a gap.

    Args:
        t_s: Times, shape (N,).
        p_m: Fingertip in the palm frame, shape (N, 3), NaN in gaps.
        strokes_s: Start and end of each stroke, shape (S, 2).
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
        found += _of_many(pieces, span.rate_hz)
    return found


def over_strokes(values: list[Estimate]) -> Estimate:
    """Mean over strokes; the interval is the t-interval of that mean, from three strokes on.

    Args:
        values: One estimate per stroke; those without a value take no part.
    """
    known = np.array([item.value for item in values if math.isfinite(item.value)])
    if not known.size:
        return Estimate.missing(values[0].reason if values else "no gap-free stroke of 5 mm or more")
    mean = float(known.mean())
    if known.size < FEWEST_FOR_INTERVAL:
        return Estimate(mean, None, f"no interval: {known.size} of at least {FEWEST_FOR_INTERVAL}")
    half = float(stdtrit(known.size - 1, 0.975)) * float(known.std(ddof=1)) / math.sqrt(known.size)
    return Estimate(mean, (mean - half, mean + half))


def smoothness_floor(
    values: list[StrokeValues], noise_m: float, rng: np.random.Generator
) -> tuple[Estimate, Estimate]:
    """SPARC and LDLJ that perfectly smooth strokes of this size, time and noise would be given.

    A minimum-jerk stroke with the median chord, duration and rate of the recording, plus white noise of the
    recorded size per axis, goes through the same filter and the same functions, 20 times.

    Args:
        values: The strokes that were made.
        noise_m: Standard deviation of the fingertip per axis.
        rng: Source of the noise.
    """
    timed = [item for item in values if math.isfinite(item.movement_time.value)]
    if not timed or not math.isfinite(noise_m):
        missing = Estimate.missing("the measurement's noise or strokes are unknown")
        return missing, missing
    rate = float(np.median([item.rate_hz for item in timed]))
    duration = float(np.median([item.movement_time.value for item in timed])) / ONSET_TO_OFFSET
    chord = float(np.median([item.chord_m for item in timed]))
    rest = np.zeros(round(0.5 * rate))
    tau = np.linspace(0.0, 1.0, max(8, round(duration * rate) + 1))
    travel = np.concatenate((rest, 10 * tau**3 - 15 * tau**4 + 6 * tau**5, rest + 1.0))
    p_m = rng.normal(0.0, noise_m, (FLOOR_DRAWS, travel.size, 3))
    p_m[:, :, 0] += chord * travel
    drawn = _of_many([low_pass(one, rate) for one in p_m], rate)
    return over_strokes([item.sparc for item in drawn]), over_strokes([item.ldlj for item in drawn])


def _of_many(paths_m: list[Float64], rate_hz: float) -> list[StrokeValues]:
    """Numbers of strokes (N, 3) that travelled far enough; their spectra are transformed together."""
    paths = [
        path
        for path in paths_m
        if len(path) >= 2 and float(np.linalg.norm(np.ptp(path, axis=0))) >= SMALLEST_STROKE_M
    ]
    speeds = [speed_m_s(path, rate_hz) for path in paths]
    rows = [active_rows(speed) for speed in speeds]
    profiles = [speed[used] for speed, used in zip(speeds, rows, strict=True)]
    smooth, jerky = sparc_many(profiles, rate_hz), ldlj_many(profiles, rate_hz)
    return [
        StrokeValues(
            arc,
            jerk,
            time_of(used, rate_hz),
            peak_speed(speed),
            path_ratio(path[used]),
            float(np.linalg.norm(path[used][-1] - path[used][0])),
            rate_hz,
        )
        for path, speed, used, arc, jerk in zip(paths, speeds, rows, smooth, jerky, strict=True)
    ]
