"""How much of a take was really seen: share of measured frames, longest gap, residual of the fit."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sessions.metrics.metric import Estimate
from sessions.records.fields import Float64


def valid_share(measured: NDArray[np.bool_]) -> Estimate:
    """Part of the frames (N,) in which the marker was measured."""
    return Estimate(float(measured.mean())) if measured.size else Estimate.missing("no frame was recorded")


def longest_gap(t_s: Float64, measured: NDArray[np.bool_]) -> Estimate:
    """Longest time between two measured frames less one frame; a gap at either end counts to the end.

    Args:
        t_s: Times of the frames, shape (N,).
        measured: Whether the marker was measured, shape (N,).
    """
    if t_s.size < 2:
        return Estimate.missing("fewer than two frames were recorded")
    step = float(np.median(np.diff(t_s)))
    seen = np.concatenate(([t_s[0] - step], t_s[measured], [t_s[-1] + step]))
    return Estimate(max(0.0, float(np.diff(seen).max()) - step))


def fit_residual(residual_m: Float64) -> Estimate:
    """Rms over the frames (N,) that were fitted; NaN rows take no part."""
    known = residual_m[np.isfinite(residual_m)]
    if not known.size:
        return Estimate.missing("no frame states a residual")
    return Estimate(float(np.sqrt(np.mean(known**2))))
