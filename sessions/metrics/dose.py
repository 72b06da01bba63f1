"""Dose and interruptions: time in movement, repetitions against the prescription, stops."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sessions.metrics.metric import Estimate
from sessions.records.fields import Float64

JUMP_S = 5.0
"""The hand is recorded many times a second; a longer step tells nothing of what was done in it."""


def time_in(
    t_s: Float64, phase: NDArray[np.str_], wanted: Sequence[str], seen_s: Float64 | None = None
) -> Estimate:
    """Seconds spent in some phases: each row lasts until the next one.

    Time that goes back counts nothing, nor does time in which the hand was not recorded for ``JUMP_S``: the
    clock jumped, or nobody knows what was done.

    Args:
        t_s: Times of the phase rows, shape (N,).
        phase: Phase of each row, shape (N,).
        wanted: Phases that count.
        seen_s: Times at which the hand was recorded, shape (M,), on the same clock; None where it always was.
    """
    if t_s.size < 2:
        return Estimate.missing("no phases were recorded")
    step = np.maximum(np.diff(t_s), 0.0)
    seen = t_s[:0] if seen_s is None else seen_s
    for row in np.flatnonzero(np.diff(seen) > JUMP_S).tolist():
        step -= np.maximum(np.minimum(t_s[1:], seen[row + 1]) - np.maximum(t_s[:-1], seen[row]), 0.0)
    return Estimate(float(np.sum(step[np.isin(phase[:-1], list(wanted))])))


def dose_completed(completed: int, prescription: str) -> Estimate:
    """Completed repetitions over prescribed ones.

    Args:
        completed: Repetitions that reached their end.
        prescription: JSON object of the session's header; its ``repetitions`` is what was ordered.
    """
    ordered = prescribed_repetitions(prescription)
    if ordered is None:
        return Estimate.missing("the file does not say how many repetitions were prescribed")
    return Estimate(completed / ordered)


def prescribed_repetitions(prescription: str) -> int | None:
    """How many repetitions the header's prescription orders, None where it does not say."""
    try:
        content: Any = json.loads(prescription)
    except ValueError:
        return None
    ordered: Any = content.get("repetitions") if isinstance(content, dict) else None
    return ordered if isinstance(ordered, int) and not isinstance(ordered, bool) and ordered > 0 else None


def adherence(held: int, days: float, per_week: int) -> Estimate:
    """Sessions held over sessions ordered, counted, so without an interval.

    Args:
        held: Sessions held within the time.
        days: Length of the time, days.
        per_week: Sessions ordered for a week.
    """
    if per_week <= 0 or not days > 0.0:
        return Estimate.missing("no sessions were ordered for that time")
    return Estimate(held / (per_week * days / 7.0))
