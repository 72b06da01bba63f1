"""Gaps are carried: a series is cut into gap-free spans, and only inside one is it put on a uniform grid."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sessions.records.fields import Float64

LONGEST_STEP = 2.5
"""A step longer than this many median steps is a gap."""
HIGHEST_RATE_HZ = 200.0
"""Faster series are brought down to this: nothing here looks above 10 Hz."""


@dataclass(frozen=True, slots=True)
class Span:
    """One gap-free stretch on a uniform grid.

    Attributes:
        t_s: Times, shape (N,).
        values: Values, shape (N, ...).
        rate_hz: Samples per second.
    """

    t_s: Float64
    values: Float64
    rate_hz: float


def gap_free(t_s: Float64, valid: NDArray[np.bool_]) -> list[slice]:
    """Row ranges without a gap: all valid, times rising, no step longer than ``LONGEST_STEP`` medians.

    Args:
        t_s: Times, shape (N,).
        valid: Whether each row may be used, shape (N,).
    """
    if t_s.size < 2:
        return []
    step = np.diff(t_s)
    rising = step[step > 0]
    if not rising.size:
        return []
    longest = LONGEST_STEP * float(np.median(rising))
    joined = valid[1:] & valid[:-1] & (step > 0) & (step <= longest)
    edges = np.diff(np.concatenate(([0], joined.astype(np.int8), [0])))
    starts, ends = np.flatnonzero(edges == 1), np.flatnonzero(edges == -1)
    return [slice(int(a), int(b) + 1) for a, b in zip(starts, ends, strict=True)]


def uniform_spans(t_s: Float64, values: Float64, shortest_s: float = 0.3) -> list[Span]:
    """Cut a series at its gaps and put each stretch on a uniform grid by linear interpolation.

    Args:
        t_s: Times, shape (N,).
        values: Values, shape (N,) or (N, D); a row with a NaN is a gap.
        shortest_s: Stretches shorter than this (or than 8 samples) are left out.
    """
    flat = values.reshape(len(values), -1)
    found: list[Span] = []
    whole: NDArray[np.bool_] = np.atleast_1d(np.isfinite(flat).all(axis=1))
    for rows in gap_free(t_s, whole):
        t = t_s[rows]
        rate = min(HIGHEST_RATE_HZ, float((t.size - 1) / (t[-1] - t[0])))
        count = round(float(t[-1] - t[0]) * rate) + 1
        if t[-1] - t[0] < shortest_s or count < 8:
            continue
        grid = t[0] + np.arange(count) / rate
        columns = [np.interp(grid, t, column) for column in flat[rows].T]
        found.append(Span(grid, np.stack(columns, axis=-1).reshape(count, *values.shape[1:]), rate))
    return found
