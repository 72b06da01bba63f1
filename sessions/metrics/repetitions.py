"""Repetitions of a take: cycles of the hand's main movement, and the strokes between its turning points."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy import signal

from sessions.metrics.filtering import low_pass
from sessions.metrics.spans import Span, uniform_spans
from sessions.records.fields import Float64

SMALLEST_RAD = math.radians(10.0)
"""A turn smaller than this is no repetition."""
SMALLEST_SHARE = 0.3
"""Nor is one smaller than this share of the whole excursion."""
NEAR_SHARE = 0.1
"""Within this share of the whole excursion the hand is at its turning point."""
SEEN_SHARE = 0.5
"""A joint takes part in the main movement where it was seen in at least this share of the rows."""


@dataclass(frozen=True, slots=True)
class Cycles:
    """What the main movement did.

    Attributes:
        count: Complete repetitions (there and back).
        strokes_s: Start and end of every single movement there or back, shape (S, 2).
        stroke_rad: How far each of them went, shape (S,).
        rate_hz: Repetitions per second from the first turning point to the last, NaN below two.
        amplitude_rad: Whole excursion of the main movement, rad (root sum square over joints).
    """

    count: int
    strokes_s: Float64
    stroke_rad: Float64
    rate_hz: float
    amplitude_rad: float


def main_movement(joints_rad: Float64, flexion: Float64) -> Float64:
    """The direction in which the joints move most, as one angle, shape (N,).

    The first principal component of all joints that were seen; its sign is such that flexion counts as
    closing. A row in which one of those joints is missing is NaN.

    Args:
        joints_rad: Angles, shape (N, J), NaN where not measured.
        flexion: 1 for joints whose positive angle closes the hand, 0 for the others, shape (J,).
    """
    seen = np.isfinite(joints_rad).mean(axis=0) >= SEEN_SHARE
    result = np.full(len(joints_rad), np.nan)
    if not bool(seen.any()):
        return result
    centred = joints_rad[:, seen]
    rows = np.isfinite(centred).all(axis=1)
    if np.count_nonzero(rows) < 2:
        return result
    centred = centred if bool(rows.all()) else centred[rows]
    centred -= centred.mean(axis=0)
    _, axes = np.linalg.eigh(centred.T @ centred)
    axis = axes[:, -1]
    closing = float(axis @ flexion[seen])
    if closing < 0 or (closing == 0 and float(axis[np.argmax(np.abs(axis))]) < 0):
        axis = -axis
    result[rows] = centred @ axis
    return result


def cycles(t_s: Float64, movement_rad: Float64) -> Cycles:
    """Count there-and-back cycles of a movement, within gap-free spans only.

    Args:
        t_s: Times, shape (N,).
        movement_rad: The main movement, shape (N,), NaN in gaps.
    """
    spans = uniform_spans(t_s, movement_rad)
    smooth = [low_pass(span.values, span.rate_hz) for span in spans]
    if not smooth:
        return Cycles(0, np.empty((0, 2)), np.empty(0), math.nan, math.nan)
    amplitude = max(float(part.max()) for part in smooth) - min(float(part.min()) for part in smooth)
    prominence = max(SMALLEST_RAD, SMALLEST_SHARE * amplitude)
    count, strokes, turns = 0, list[tuple[float, float, float]](), list[float]()
    for span, part in zip(spans, smooth, strict=True):
        found = _turns(part, prominence)
        highs, lows = _alternating(found)
        count += max(len(highs), len(lows))
        turns += [_middle_s(span, part, turn, amplitude) for turn in max(highs, lows, key=len)]
        strokes += _strokes(span, part, [turn for turn, _ in found], prominence)
    rate = (len(turns) - 1) / (turns[-1] - turns[0]) if len(turns) >= 2 else math.nan
    rows = np.array(strokes, dtype=np.float64).reshape(-1, 3)
    return Cycles(count, rows[:, :2], rows[:, 2], rate, amplitude)


def _turns(part: Float64, prominence: float) -> list[tuple[int, int]]:
    """Rows of the turning points in their order, each with 0 for a high and 1 for a low."""
    highs, _ = signal.find_peaks(part, prominence=prominence)
    lows, _ = signal.find_peaks(-part, prominence=prominence)
    return sorted([(int(turn), 0) for turn in highs] + [(int(turn), 1) for turn in lows])


def _alternating(turns: list[tuple[int, int]]) -> tuple[list[int], list[int]]:
    """Highs and lows in turn; of equal highs with no low between, as at the ends of a hold, the first."""
    found: tuple[list[int], list[int]] = ([], [])
    before = -1
    for turn, kind in turns:
        if kind != before:
            found[kind].append(turn)
        before = kind
    return found


def _middle_s(span: Span, part: Float64, turn: int, amplitude: float) -> float:
    """Middle of the time that was spent near a turning point: in a hold the turn itself may lie anywhere."""
    away = np.abs(part - part[turn]) > NEAR_SHARE * amplitude
    before, after = np.flatnonzero(away[:turn]), np.flatnonzero(away[turn:])
    first = int(before[-1]) + 1 if before.size else 0
    last = turn + int(after[0]) - 1 if after.size else part.size - 1
    return 0.5 * float(span.t_s[first] + span.t_s[last])


def _strokes(
    span: Span, part: Float64, turns: Sequence[int], smallest: float
) -> list[tuple[float, float, float]]:
    """Stretches between neighbouring turning points (the ends of the span among them) that travel enough."""
    edges = [0, *turns, part.size - 1]
    return [
        (float(span.t_s[a]), float(span.t_s[b]), abs(float(part[b] - part[a])))
        for a, b in pairwise(edges)
        if abs(float(part[b] - part[a])) >= smallest
    ]
