"""Shape and time of one stroke: onset and offset, movement time, peak speed, path ratio."""

from __future__ import annotations

import numpy as np

from sessions.metrics.metric import Estimate
from sessions.records.fields import Float64

ONSET_SHARE = 0.05
"""A stroke lasts from the first to the last sample above this share of its peak speed."""
CLOSED_SHARE = 0.05
"""A path whose ends lie nearer than this share of its length is closed: the ratio says nothing."""


def active_rows(speed: Float64, still: float = 0.0) -> slice:
    """From onset to offset: first to last row above a twentieth of the peak and above what counts as still.

    Args:
        speed: Profile, shape (N,).
        still: Speed that noise alone may reach, in the profile's unit; nothing moves at or below it.
    """
    if not speed.size or not float(speed.max()) > still:
        return slice(0, 0)
    above = np.flatnonzero(speed > max(ONSET_SHARE * float(speed.max()), still))
    return slice(int(above[0]), int(above[-1]) + 1)


def movement_time(speed: Float64, rate_hz: float) -> Estimate:
    """Seconds from onset to offset, of a speed profile (N,)."""
    return time_of(active_rows(speed), rate_hz)


def time_of(rows: slice, rate_hz: float) -> Estimate:
    """Seconds from onset to offset, of the rows that ``active_rows`` gives."""
    if rows.stop - rows.start < 2:
        return Estimate.missing("nothing moved")
    return Estimate((rows.stop - rows.start - 1) / rate_hz)


def peak_speed(speed: Float64) -> Estimate:
    """Highest value of a speed profile (N,), in its own unit."""
    return Estimate(float(speed.max())) if speed.size else Estimate.missing("no gap-free stroke")


def path_ratio(p_m: Float64) -> Estimate:
    """Length of a path over the distance of its ends.

    Args:
        p_m: Positions, shape (N, D).
    """
    if len(p_m) < 2 or not bool(np.isfinite(p_m).all()):
        return Estimate.missing("no gap-free path")
    length = float(np.sum(np.linalg.norm(np.diff(p_m, axis=0), axis=1)))
    chord = float(np.linalg.norm(p_m[-1] - p_m[0]))
    if length <= 0.0:
        return Estimate.missing("nothing moved")
    if chord < CLOSED_SHARE * length:
        return Estimate.missing("the path returns to where it began")
    return Estimate(length / chord)
