"""Where the repetitions are: of a session from its phases, of a take from the movement itself."""

from __future__ import annotations

import numpy as np

from sessions.metrics.repetitions import cycles, main_movement
from sessions.records import JOINTS
from sessions.records.fields import Float64, Int64
from sessions.records.topics import PHASE
from sessions.store import SessionReader

NONE: Float64 = np.empty((0, 2))
_FLEXION: Float64 = np.array([0.0 if name.endswith("abduction") else 1.0 for name in JOINTS])
_OUTSIDE = ("approach", "ramp", "stopped", "done", "")


def of_movement(t_s: Float64, joints_rad: Float64) -> Float64:
    """Start and end of every repetition of a movement, there and back, shape (R, 2), s.

    Args:
        t_s: Times, shape (N,).
        joints_rad: The hand, shape (N, 21), NaN where it was not seen.
    """
    if t_s.size < 2:
        return NONE
    strokes = cycles(t_s, main_movement(joints_rad, _FLEXION)).strokes_s
    pairs = [(strokes[at][0], strokes[at + 1][1]) for at in range(0, len(strokes) - 1, 2)]
    return np.array(pairs, dtype=np.float64).reshape(-1, 2)


def of_session(reader: SessionReader, start_ns: int, end_ns: int) -> Float64:
    """Start and end of every repetition that a session's phases name, shape (R, 2), s from ``start_ns``."""
    rows = reader.columns(PHASE, names=("phase", "repetition"))
    t_ns: Int64 = np.asarray(rows["t_ns"], dtype=np.int64)
    if t_ns.size == 0:
        return NONE
    ends_ns = np.append(t_ns[1:], max(end_ns, int(t_ns[-1])))
    inside = ~np.isin(np.asarray(rows["phase"]).astype(str), _OUTSIDE)
    number: Int64 = np.where(inside, np.asarray(rows["repetition"], dtype=np.int64), -1)
    spans = [
        (t_ns[number == one].min() - start_ns, ends_ns[number == one].max() - start_ns)
        for one in np.unique(number[number >= 0])
    ]
    return np.array(spans, dtype=np.float64).reshape(-1, 2) / 1e9
