"""What is kept of the robot's ticks in one repetition: sums, extremes, and a track of 10 ms steps."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sessions.metrics.effort import Work, works
from sessions.metrics.recording import seconds
from sessions.records.fields import Float64, Int64

STEP_NS = 10_000_000
"""Step of the track: fingers move below 6 Hz, and a passive curve is quasi-static."""


@dataclass(frozen=True, slots=True)
class Track:
    """Means over steps of 10 ms, N steps and J joints.

    Attributes:
        t_ns: Time of the first tick of each step, shape (N,).
        q_rad: Positions, shape (N, J).
        dq_rad_s: Speeds, shape (N, J).
        tau_nm: Interaction torque, NaN where a tick had none, shape (N, J).
        passive: Whether the step was in passive mode, shape (N,).
        repetition: Repetition index, shape (N,).
    """

    t_ns: Int64
    q_rad: Float64
    dq_rad_s: Float64
    tau_nm: Float64
    passive: NDArray[np.bool_]
    repetition: Int64


@dataclass(frozen=True, slots=True)
class Stretch:
    """Ticks of one repetition without another between, J joints.

    Attributes:
        repetition: Its index.
        passive: Whether it was in passive mode throughout.
        span_ns: Time of the first and last tick.
        works: Work at each joint.
        low_rad: Smallest position, shape (J,).
        high_rad: Largest position, shape (J,).
        square_nm2: Sum of squares of the interaction torque, shape (J,).
        known: Number of ticks whose torque was measured, shape (J,).
        peak_nm: Largest absolute interaction torque, NaN where it was not measured, shape (J,).
        track: Means over 10 ms.
    """

    repetition: int
    passive: bool
    span_ns: tuple[int, int]
    works: tuple[Work, ...]
    low_rad: Float64
    high_rad: Float64
    square_nm2: Float64
    known: Int64
    peak_nm: Float64
    track: Track


def stretch(
    repetition: int, t_ns: Int64, measured: tuple[Float64, Float64, Float64], passive: NDArray[np.bool_]
) -> Stretch:
    """Take together the ticks of one repetition.

    Args:
        repetition: Its index.
        t_ns: Times of the ticks, shape (N,).
        measured: Positions, speeds and interaction torques, each (J, N); torques NaN where not measured.
        passive: Whether each tick was in passive mode, shape (N,).
    """
    q, dq, tau = measured
    known = np.isfinite(tau)
    magnitude = np.abs(tau if bool(known.all()) else np.where(known, tau, 0.0))
    peak = np.where(known.any(axis=1), magnitude.max(axis=1), math.nan)
    return Stretch(
        repetition,
        bool(passive.all()),
        (int(t_ns[0]), int(t_ns[-1])),
        works(seconds(t_ns), tau, dq),
        q.min(axis=1),
        q.max(axis=1),
        np.einsum("jn,jn->j", magnitude, magnitude),
        known.sum(axis=1),
        peak,
        _track(repetition, t_ns, (q, dq, tau), passive),
    )


def _track(
    repetition: int, t_ns: Int64, measured: tuple[Float64, Float64, Float64], passive: NDArray[np.bool_]
) -> Track:
    step = (t_ns - t_ns[0]) // STEP_NS
    first = np.flatnonzero(np.diff(step, prepend=step[0] - 1))
    count = np.diff(first, append=t_ns.size)
    q, dq, tau = ((np.add.reduceat(column, first, axis=1) / count).T for column in measured)
    of = np.full(first.size, repetition, dtype=np.int64)
    return Track(t_ns[first], q, dq, tau, passive[first], of)


def joined_track(stretches: Sequence[Stretch]) -> Track | None:
    """The tracks of all stretches, one after the other; None where there is none."""
    if not stretches:
        return None
    tracks = [one.track for one in stretches]
    names = ("t_ns", "q_rad", "dq_rad_s", "tau_nm", "passive", "repetition")
    return Track(*(np.concatenate([getattr(one, name) for one in tracks]) for name in names))
