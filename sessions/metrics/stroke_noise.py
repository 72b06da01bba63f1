"""What the measurement's noise does to the numbers of strokes, found with strokes whose truth is known.

Noise moves them all to one side: a movement looks longer, rougher and faster than it was. A smooth stroke of
the recorded size, time and rate goes through the same filter and functions with the noise and without it;
what lies between is how far the true number may be from the measured one.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from sessions.metrics.filtering import low_pass
from sessions.metrics.metric import Estimate
from sessions.metrics.movement import ONSET_SHARE
from sessions.metrics.strokes import Reach, StrokeValues, noise_speed_m_s, of_many, over_strokes
from sessions.records.fields import Float64

DRAWS = 20
NOISE_TAILS: Mapping[str, float] = {
    "sparc": 3.0,
    "ldlj": 2.2,
    "movement_time": 2.2,
    "peak_speed": 2.5,
    "path_ratio": 2.2,
}
"""Errors of a tracked fingertip, tail and all, over their stated size, as each number feels them: the virtual
camera's, seeds 241 to 246. SPARC feels the slow part of them, which white noise has less of."""
_OUT_AND_BACK_SHARE = 0.5
"""A stroke whose ends lie nearer than this share of its reach went out and came back."""
_UNKNOWN = Estimate.missing("the measurement's noise or strokes are unknown")


def smoothness_floor(
    values: Sequence[StrokeValues], noise_m: float, rng: np.random.Generator
) -> tuple[Estimate, Estimate]:
    """SPARC and LDLJ that perfectly smooth strokes of this size, time and noise would be given.

    Args:
        values: The strokes that were made.
        noise_m: Standard deviation of the fingertip per axis, from frame to frame.
        rng: Source of the noise.
    """
    typical = _typical(values, noise_m)
    if typical is None:
        return _UNKNOWN, _UNKNOWN
    drawn = _drawn(typical, _travel(typical, noise_m), (noise_m, noise_m), rng)
    return over_strokes([item.sparc for item in drawn]), over_strokes([item.ldlj for item in drawn])


def noise_reach(
    values: Sequence[StrokeValues], noise_m: float, rng: np.random.Generator
) -> Mapping[str, Reach]:
    """By number of ``NOISE_TAILS``: how far the measurement moves it, measured less true, least and most.

    From a measurement without any noise, which only loses a stroke's slow ends, to one with the whole tail of
    it. Onset and offset are each known to a frame. (0, 0) where there is no stroke or its noise is unknown.

    Args:
        values: The strokes that were made.
        noise_m: Standard deviation of the fingertip per axis, from frame to frame.
        rng: Source of the noise.
    """
    typical = _typical(values, noise_m)
    if typical is None:
        return dict.fromkeys(NOISE_TAILS, (0.0, 0.0))
    reach = dict.fromkeys(NOISE_TAILS, (0.0, 0.0)) if noise_m == 0.0 else _moved(typical, noise_m, rng)
    least, most = reach["movement_time"]
    frames_s = 2.0 / typical.rate_hz
    return {**reach, "movement_time": (least - frames_s, most + frames_s)}


def _moved(typical: StrokeValues, noise_m: float, rng: np.random.Generator) -> dict[str, Reach]:
    travel = _travel(typical, noise_m)
    clean = _drawn(typical, travel, (0.0, 0.0), rng, draws=1)
    tails = (0.0, 1.0, *sorted(set(NOISE_TAILS.values())))
    drawn = {tail: _drawn(typical, travel, (tail * noise_m, noise_m), rng) for tail in tails}
    return {
        name: _span([_mean(drawn[each], name) - _mean(clean, name) for each in (0.0, 1.0, tail)])
        for name, tail in NOISE_TAILS.items()
    }


def _span(moved: Sequence[float]) -> Reach:
    known = [each for each in moved if math.isfinite(each)]
    return (min(0.0, *known), max(0.0, *known)) if known else (0.0, 0.0)


def _typical(values: Sequence[StrokeValues], noise_m: float) -> StrokeValues | None:
    """The stroke nearest to the median movement time, None where there is none."""
    timed = [item for item in values if math.isfinite(item.movement_time.value)]
    if not timed or not math.isfinite(noise_m):
        return None
    timed.sort(key=lambda item: item.movement_time.value)
    return timed[(len(timed) - 1) // 2]


def _drawn(
    like: StrokeValues,
    travel: Float64,
    noises_m: tuple[float, float],
    rng: np.random.Generator,
    draws: int = DRAWS,
) -> list[StrokeValues]:
    """Numbers of that travel with noise of one size, read as if it were known to be of another."""
    noise_m, known_m = noises_m
    p_m = rng.normal(0.0, noise_m, (travel.size, draws, 3))
    p_m[:, :, 0] += like.reach_m * travel[:, None]
    smooth = low_pass(p_m, like.rate_hz)
    return of_many([smooth[:, draw] for draw in range(draws)], like.rate_hz, known_m)


def _travel(like: StrokeValues, noise_m: float) -> Float64:
    """Minimum-jerk travel from 0 to 1, or out and back, shape (N,), with the rest that the window holds."""
    share = max(ONSET_SHARE, noise_speed_m_s(noise_m, like.rate_hz) / like.peak_speed.value)
    above = math.sqrt(max(1.0 - math.sqrt(min(share, 1.0)), 0.04))
    back = like.chord_m < _OUT_AND_BACK_SHARE * like.reach_m
    seen_s = like.movement_time.value
    duration_s = seen_s / ((1.0 + above) / 2.0 if back else above)
    window_s = max(like.window_s, duration_s)
    rows = max(8, round(window_s * like.rate_hz) + 1)
    tau = (np.linspace(0.0, window_s, rows) - 0.5 * (window_s - duration_s)) / duration_s
    if not back:
        return _minimum_jerk(tau)
    return _minimum_jerk(2.0 * tau) - _minimum_jerk(2.0 * tau - 1.0)


def _minimum_jerk(tau: Float64) -> Float64:
    held = np.clip(tau, 0.0, 1.0)
    return held**3 * (10.0 - 15.0 * held + 6.0 * held**2)


def _mean(values: Sequence[StrokeValues], name: str) -> float:
    known = [value for value in (getattr(item, name).value for item in values) if math.isfinite(value)]
    return float(np.mean(known)) if known else math.nan
