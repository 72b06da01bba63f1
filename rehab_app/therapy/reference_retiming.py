"""Local re-timing: where a movement is too fast for the limits, and only there, time is stretched.

The hand takes the same postures in the same order. r(t) says by how much each instant of the take's time
is stretched: at least what the fastest joint needs, 1 where nothing is needed, smooth in between. Its
logarithm is the need's, first held for as long as the kernel reaches and then averaged with a smooth kernel:
an average of values that all meet the need meets it too.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.ndimage import maximum_filter1d

from rehab_app.therapy.reference_speed import (
    SPEED_MARGIN,
    instants,
    speed_share,
    speed_words,
)
from robot_iface.motion import QuinticPath
from robot_iface.types import Limits, ReferencePath
from sessions.errors import Refused
from sessions.records.fields import Float64

MOST = 20.0
"""Largest local stretch: beyond it a movement is not the one that was shown."""

_KNOT_S = 0.02
_REACH_S = 0.15  # of the take's time over which a stretch sets in; longer is gentler but lasts longer
_USED_SHARE = 0.97  # of a limit in the first attempt: a hair below SPEED_MARGIN, for the new spline
_ATTEMPTS = 8
_LEAST_STEP = 0.8  # by which the used share falls from one attempt to the next at most
_NOTED = 1.01  # from this stretch on an instant counts as slowed


@dataclass(frozen=True, slots=True)
class Retimed:
    """A path with its own timing.

    Attributes:
        path: The re-timed path; the very path that was given where nothing had to be slowed.
        from_s: Coordinate on the given path of each knot, strictly increasing, shape (N,).
        note: One sentence on what was slowed; empty if nothing was.
    """

    path: ReferencePath
    from_s: Float64
    note: str


def retime(path: ReferencePath, limits: Limits, speed: float, take_start_s: float = 0.0) -> Retimed:
    """Stretch time where a path, played at a speed, would break a directed speed limit.

    Args:
        path: The path in the therapist's own timing.
        limits: Bounds of its joints.
        speed: Prescribed path speed, more than 0, at most 1.
        take_start_s: Time in the take at which the path begins, for the words of note and refusal.

    Returns:
        A path that keeps 98 % of every speed limit at that speed, between its knots too.

    Raises:
        Refused: The speed is out of bounds, or some instant would have to be stretched by more than 20.
    """
    if not 0.0 < speed <= 1.0:
        raise Refused("path speed", f"{speed:g}", "more than 0 and at most 1", "choose another speed")
    spline = QuinticPath(path)
    path_s = instants(spline.duration_s)
    share = speed * speed_share(spline, path_s, limits)
    row, joint = divmod(int(np.argmax(share)), share.shape[1])
    if share[row, joint] <= SPEED_MARGIN:
        return Retimed(path, path.t_s, "")
    moves, allowed = speed_words(spline, float(path_s[row]), joint, limits, speed)
    name, at = path.joint_names[joint], f"at {take_start_s + path_s[row]:.1f} s of the take"
    if share[row, joint] > MOST * _USED_SHARE:
        raise _too_fast(f"{name} {at}", f"moving at {moves}, {share[row, joint]:.0f} times what is allowed")
    slow, retimed, from_s = _within_limits(path, spline, share.max(axis=1), limits, speed)
    slowed_s = float((slow > _NOTED).sum()) * float(path_s[1])
    note = (
        f"Slowed locally to keep the limits at {100 * speed:.0f} % of the therapist's speed: "
        f"{slowed_s:.1f} of {spline.duration_s:.1f} s, most {at} ({name} would move at {moves}, {allowed}); "
        f"one pass lasts {retimed.t_s[-1] / speed:.1f} s instead of {spline.duration_s / speed:.1f} s."
    )
    return Retimed(retimed, from_s, note)


def _within_limits(
    path: ReferencePath, spline: QuinticPath, need: Float64, limits: Limits, speed: float
) -> tuple[Float64, ReferencePath, Float64]:
    """Stretch (n,) of each instant, the re-timed path and where its knots lie on the given one.

    A spline through new knots differs a little from the curve it samples; should it exceed a limit,
    everything that is near its limit is asked to be slower by as much.
    """
    path_s = instants(spline.duration_s)
    used = _USED_SHARE
    for _ in range(_ATTEMPTS):
        slow = stretch(need / used, float(path_s[1]))
        knots_s, from_s = _knots(path_s, slow)
        retimed = replace(path, t_s=knots_s, q_rad=spline.sample(from_s))
        again = QuinticPath(retimed)
        worst = speed * float(speed_share(again, instants(again.duration_s), limits).max())
        if worst <= SPEED_MARGIN:
            return slow, retimed, from_s
        used *= max(0.99 * SPEED_MARGIN / worst, _LEAST_STEP)
    raise _too_fast("take", f"beyond its speed limits after {_ATTEMPTS} attempts to slow it")


def _too_fast(thing: str, value: str) -> Refused:
    bound = f"at most {MOST:.0f} times as fast as the limits allow, so that slowing it locally can help"
    return Refused(thing, value, bound, "play it at a lower speed or record the movement more slowly there")


def stretch(need: Float64, step_s: float) -> Float64:
    """A smooth stretch of time that is nowhere below the need and 1 wherever no need is near.

    Args:
        need: Stretch that is needed at equally spaced instants, above 1 where any is, shape (n,).
        step_s: Their distance.

    Returns:
        The stretch, shape (n,), 1 or more; its second derivative is continuous but for the sampling.
    """
    kernel = _kernel(step_s)
    reach = len(kernel) // 2
    held = maximum_filter1d(np.log(np.maximum(need, 1.0)), len(kernel), mode="nearest")
    return np.exp(np.convolve(np.pad(held, reach, mode="edge"), kernel, "valid"))


def _kernel(step_s: float) -> Float64:
    """Cubic B-spline of about 0.15 s to either side, as weights of an odd number of samples."""
    box = np.ones(2 * round(_REACH_S / (4.0 * step_s)) + 1)
    pair = np.convolve(box, box)
    kernel = np.convolve(pair, pair)
    return kernel / kernel.sum()


def _knots(path_s: Float64, slow: Float64) -> tuple[Float64, Float64]:
    """Knots (N,) equally spaced in stretched time, and where they lie on the given path (N,)."""
    passed_s = 0.5 * (slow[1:] + slow[:-1]) * np.diff(path_s)
    new_s = np.concatenate(([0.0], np.cumsum(passed_s)))
    steps = int(np.ceil(new_s[-1] / _KNOT_S))
    knots_s = np.linspace(0.0, float(new_s[-1]), steps + 1)
    from_s: Float64 = CubicSpline(new_s, path_s)(knots_s)
    from_s[0], from_s[-1] = path_s[0], path_s[-1]
    return knots_s, from_s
