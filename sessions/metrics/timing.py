"""Error against the therapist taken apart: too late, otherwise shaped, or beside it throughout.

A patient who makes the right movement half a second late and one who makes another movement may have the same
root mean square error. Here the constant offset is taken out first, then the best delay is found, and what
dynamic time warping cannot bring together is the shape.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import dtaidistance
import numpy as np
from dtaidistance import dtw_ndim as _dtw_ndim
from numpy.typing import NDArray

from sessions.metrics.metric import Estimate
from sessions.records.fields import Float64, Int64

dtw: Any = dtaidistance.dtw
dtw_ndim: Any = _dtw_ndim
RATE_HZ = 20.0
"""Rate at which two movements are compared: fingers move below 6 Hz, and warping grows with its square."""
WINDOW_S = 1.0
"""Farthest that the warping may shift an instant; the delay is looked for within it, too."""
LONGEST_S = 60.0
"""Longer repetitions are not taken apart: the table of the warping grows with the square."""
JUMP_S = 5.0
"""Nothing is laid across a longer step: the clock jumped, or the hand was away."""
MOVING_SHARE = 0.2
SHORTEST = 8
_ROUNDS = 3


@dataclass(frozen=True, slots=True)
class Decomposition:
    """One digit in one repetition.

    Attributes:
        delay: How far the patient is behind as a whole, s; negative when ahead.
        warp: Root mean square shift of instants that the warping needs while the reference moves, s: where
            it rests, any instant fits any other.
        shape: Root mean square distance left after warping and without the offset, m.
        offset: Length of the constant distance, m.
    """

    delay: Estimate
    warp: Estimate
    shape: Estimate
    offset: Estimate


def decompose(t_s: Float64, patient_m: Float64, reference_m: Float64) -> Decomposition:
    """Take the error of one movement apart.

    Args:
        t_s: Times, rising, shape (N,).
        patient_m: Patient, shape (N, D); rows with NaN are left out.
        reference_m: Therapist at the same path coordinate, same shape.
    """
    there = np.isfinite(patient_m).all(axis=1) & np.isfinite(reference_m).all(axis=1)
    if int(there.sum()) < SHORTEST or float(np.ptp(t_s[there])) * RATE_HZ < SHORTEST:
        return _nothing("less than 0.4 s of the movement was measured")
    step = np.diff(t_s[there])
    if float(step.min()) <= 0.0 or float(step.max()) > JUMP_S:
        return _nothing("the clock jumped, or the hand was not seen for a while")
    if float(np.ptp(t_s[there])) > LONGEST_S:
        return _nothing(f"longer than {LONGEST_S:.0f} s")
    patient, reference = (_even(t_s[there], values[there]) for values in (patient_m, reference_m))
    offset = (patient - reference).mean(axis=0)
    path = _warped(patient - offset, reference)
    for _ in range(_ROUNDS):
        offset = (patient[path[:, 0]] - reference[path[:, 1]]).mean(axis=0)
        path = _warped(patient - offset, reference)
    apart = patient[path[:, 0]] - reference[path[:, 1]]
    shape = np.linalg.norm(apart - offset, axis=1)
    shift_s = (path[:, 0] - path[:, 1])[_moving(reference)[path[:, 1]]] / RATE_HZ
    return Decomposition(
        Estimate(_delay_s(patient, reference)),
        Estimate(float(np.sqrt(np.mean(shift_s**2))) if shift_s.size else 0.0),
        Estimate(float(np.sqrt(np.mean(shape**2)))),
        Estimate(float(np.linalg.norm(offset))),
    )


def _nothing(reason: str) -> Decomposition:
    missing = Estimate.missing(reason)
    return Decomposition(missing, missing, missing, missing)


def warped_distance(one: Float64, other: Float64) -> float:
    """Dynamic time warping distance, sum of |a - b| along the best path, of shapes (N,) or (N, D)."""
    series = [np.ascontiguousarray(values.reshape(len(values), -1)) for values in (one, other)]
    return float(dtw_ndim.distance(*series, inner_dist="euclidean", use_c=True))


def _moving(reference: Float64) -> NDArray[np.bool_]:
    """Rows in which the reference, (N, D), moves faster than a share of its peak."""
    speed = np.linalg.norm(np.gradient(reference, axis=0), axis=1)
    return speed >= MOVING_SHARE * max(float(speed.max()), 1e-12)


def _even(t_s: Float64, values: Float64) -> Float64:
    """Values (N, D) on an even grid of RATE_HZ."""
    grid = np.arange(t_s[0], t_s[-1] + 1e-9, 1.0 / RATE_HZ)
    return np.stack([np.interp(grid, t_s, column) for column in values.T], axis=1)


def _warped(patient: Float64, reference: Float64) -> Int64:
    """Row pairs of the best warping path, shape (P, 2)."""
    window = max(round(WINDOW_S * RATE_HZ), 2)
    _, table = dtw_ndim.warping_paths_fast(
        np.ascontiguousarray(patient),
        np.ascontiguousarray(reference),
        window=window,
        inner_dist="euclidean",
    )
    return np.array(dtw.best_path(table), dtype=np.int64)


def _delay_s(patient: Float64, reference: Float64) -> float:
    """Lag of the least mean square distance of the mean-free series, refined by a parabola."""
    most = min(round(WINDOW_S * RATE_HZ), len(patient) // 4)
    lags = np.arange(-most, most + 1)
    cost = np.array([_cost(patient, reference, int(lag)) for lag in lags])
    best = int(np.argmin(cost))
    if not 0 < best < len(lags) - 1:
        return float(lags[best]) / RATE_HZ
    left, here, right = cost[best - 1 : best + 2]
    bend = left - 2.0 * here + right
    return float(lags[best] + (0.5 * (left - right) / bend if bend > 0.0 else 0.0)) / RATE_HZ


def _cost(patient: Float64, reference: Float64, lag: int) -> float:
    late = patient[max(lag, 0) : len(patient) + min(lag, 0)]
    early = reference[max(-lag, 0) : len(reference) - max(lag, 0)]
    return float(np.mean((late - late.mean(axis=0) - early + early.mean(axis=0)) ** 2))
