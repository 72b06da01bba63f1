"""Error against the therapist: root mean square distance at the same path coordinate."""

from __future__ import annotations

import math

import numpy as np

from sessions.metrics.metric import Z95, Estimate
from sessions.records.fields import Float64


def rmse(values: Float64, reference: Float64, std: Float64) -> Estimate:
    """sqrt(mean |p - p_ref|^2) over the rows that are finite in both.

    The interval takes the measurement errors of all rows as fully correlated, which is the worst case and
    the usual one (a calibration or alignment that is off is off all the time): with e_i the distance and
    s_i the standard deviation along it, u = sum(e_i s_i) / (N RMSE) <= rms(s), and the interval is
    RMSE -+ 1.96 u, cut at 0.

    Args:
        values: Patient, shape (N,) or (N, D).
        reference: Therapist at the same path coordinate, same shape.
        std: Standard deviation of each row, per axis, shape (N,); NaN where unknown: then no interval.
    """
    if not values.size:
        return Estimate.missing("no sample was measured while the reference was played")
    error = (values - reference).reshape(len(values), -1)
    used = np.isfinite(error).all(axis=1)
    if not bool(used.any()):
        return Estimate.missing("no sample was measured while the reference was played")
    distance = np.linalg.norm(error[used], axis=1)
    value = float(np.sqrt(np.mean(distance**2)))
    spread = std[used]
    if not bool(np.isfinite(spread).all()):
        return Estimate(value)
    if value > 0.0:
        uncertainty = float(np.mean(distance * spread)) / value
    else:
        uncertainty = float(np.sqrt(np.mean(spread**2)))
    return Estimate(value, (max(0.0, value - Z95 * uncertainty), value + Z95 * uncertainty))


def rmse_columns(values: Float64, reference: Float64, std: Float64) -> list[Estimate]:
    """``rmse`` of each of J columns, (N, J) or (N, J, D) and std (N, J); those without a gap together."""
    error = values - reference
    apart = np.abs(error) if error.ndim == 2 else np.linalg.norm(error, axis=2)
    distance, spread = np.ascontiguousarray(apart.T), np.ascontiguousarray(std.T)
    if not distance.size or not bool(np.isfinite(distance).all() and np.isfinite(spread).all()):
        return [rmse(values[:, j], reference[:, j], std[:, j]) for j in range(values.shape[1])]
    level = np.sqrt(np.mean(distance**2, axis=1))
    shared = np.mean(distance * spread, axis=1) / np.where(level > 0.0, level, 1.0)
    shared = np.where(level > 0.0, shared, np.sqrt(np.mean(spread**2, axis=1)))
    return [
        Estimate(value, (max(0.0, value - Z95 * one), value + Z95 * one))
        for value, one in zip(level.tolist(), shared.tolist(), strict=True)
    ]


def pooled_rmse(parts: list[Estimate]) -> Estimate:
    """Root mean square over several joints or digits that were measured equally often.

    Args:
        parts: Their estimates; those without a value take no part. The interval pools the ends, which
            keeps errors fully correlated between them, too.
    """
    known = [part for part in parts if math.isfinite(part.value)]
    if not known:
        return Estimate.missing(parts[0].reason if parts else "nothing was measured")
    value = _rms([part.value for part in known])
    intervals = [part.interval for part in known if part.interval is not None]
    if len(intervals) < len(known):
        return Estimate(value)
    return Estimate(value, (_rms([low for low, _ in intervals]), _rms([high for _, high in intervals])))


def _rms(values: list[float]) -> float:
    return math.sqrt(sum(value * value for value in values) / len(values))
