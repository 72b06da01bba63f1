"""A path whose thumb is led past the fingers: nudged where a recording comes a little too close.

Tracking noise and a hand of another size eat a few millimetres of the distance that a therapist kept. Where
that is all, the thumb gives way by a few degrees, smoothly and as little as possible; where more would be
needed, the movement is not the one that was shown, and it stays as it is for the rehearsal to refuse.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rehab_app.hand.retarget_range import INSET, SOFT_RAD
from rehab_app.therapy.reference_bumps import bumps, roughness, windows
from robot_iface.kinematics import HandGeometry
from robot_iface.motion.clearance import CLEARANCE_M, least_clearance_m, too_close, whole_hand
from robot_iface.types import Limits
from sessions.records import FINGERS
from sessions.records.fields import Float64

MARGIN_M = 0.0003
"""Kept beyond the least clearance: room for the spline between the knots and for a local re-timing."""
MOST_RAD = float(np.deg2rad(10.0))
"""Largest change of a thumb joint: beyond it a movement is not the one that was shown."""

_ENOUGH_M = CLEARANCE_M + 0.0001  # from here on a posture is left alone
_WANTED_M = CLEARANCE_M + MARGIN_M
_REACH = 4  # windows on either side of an approach in which the thumb may begin to give way
_WATCHED_M = CLEARANCE_M + 0.006  # from here on a change is not watched for bringing a finger near
_STEPS = 12
_SETS = 12
_STEP_RAD = float(np.deg2rad(3.0))  # largest change from one step to the next
_STILL_RAD = float(np.deg2rad(0.05))  # from here on another step is not worth it
_PROBE_RAD = 0.005
_PER_CLEARANCE = 1e6  # weight of a squared metre too close beside a squared radian of change
_PER_RANGE = 1e4  # of a squared radian out of range
_PAIRS = tuple(f"thumb to {finger}" for finger in FINGERS)


@dataclass(frozen=True, slots=True)
class _Hand:
    """What a path is of.

    Attributes:
        names: The J joints.
        thumb: Columns of the T joints that may give way.
        geometry: The hand.
        low_rad: Lower ends of those T joints, shape (T,).
        high_rad: Upper ends, shape (T,).
    """

    names: tuple[str, ...]
    thumb: list[int]
    geometry: HandGeometry
    low_rad: Float64
    high_rad: Float64

    def least_m(self, q_rad: Float64) -> Float64:
        """Least distance of the thumb to each finger over postures (N, J): shape (4,)."""
        found = least_clearance_m(self.geometry, whole_hand(q_rad, self.names))
        return np.array([found[pair] for pair in _PAIRS])


@dataclass(frozen=True, slots=True)
class _Need:
    """What a window asks of the thumb: a change along ``slope`` of ``short`` or more.

    Attributes:
        slope: Gain by each thumb joint, shape (T,).
        short: What is missing; negative where there is room.
        weight: Of a missing unit squared.
        urgent: It is too much to let pass.
    """

    slope: Float64
    short: float
    weight: float
    urgent: bool


def keep_clearance(
    q_rad: Float64, names: tuple[str, ...], geometry: HandGeometry, limits: Limits, take_s: Float64
) -> tuple[Float64, tuple[str, ...]]:
    """Nudge the thumb of a path away from the fingers where their skins come closer than 5 mm.

    Args:
        q_rad: Angles inside their limits, shape (K, J).
        names: The J driven joints of the hand.
        geometry: The hand that is moved.
        limits: Bounds of those joints; a joint that shares a hull with another one is not moved.
        take_s: Time in the take of each row, equally spaced, shape (K,).

    Returns:
        The path, shape (K, J), the very one given where the clearance is kept or cannot be reached within
        10 degrees; and a sentence on what was done or would be needed.
    """
    hand = _hand(names, geometry, limits)
    if not hand.thumb or float(hand.least_m(q_rad).min()) >= _ENOUGH_M:
        return q_rad, ()
    rows = windows(take_s)
    least = np.stack([hand.least_m(q_rad[one]) for one in rows])
    worst = rows[int(np.argmin(least.min(axis=1)))]
    if _change(q_rad, hand, [worst], np.ones((len(q_rad), 1))) is None:  # not even this posture alone
        return q_rad, (_refusal(take_s, rows, least),)
    path = q_rad.copy()
    shapes = bumps(take_s, len(rows))
    for first, last in _approaches(least.min(axis=1) < _ENOUGH_M):
        change = _change(q_rad, hand, rows[first:last], shapes[:, first:last])
        if change is None:
            return q_rad, (_refusal(take_s, rows, least),)
        path[:, hand.thumb] += change
    found = too_close(geometry, whole_hand(path, names))
    if found is not None and found.between.startswith("thumb"):
        return q_rad, (_refusal(take_s, rows, least),)
    return path, (_sentence(path - q_rad, names, take_s),)


def _hand(names: tuple[str, ...], geometry: HandGeometry, limits: Limits) -> _Hand:
    bound = {name for hull in limits.hulls for name in hull.joints}
    thumb = [at for at, name in enumerate(names) if name.startswith("thumb_") and name not in bound]
    room = 0.8 * INSET * np.minimum(SOFT_RAD, (limits.q_max_rad - limits.q_min_rad)[thumb] / 12.0)
    return _Hand(names, thumb, geometry, limits.q_min_rad[thumb] + room, limits.q_max_rad[thumb] - room)


def _approaches(close: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Windows (first, past the last) around each approach, those that touch as one."""
    spans: list[tuple[int, int]] = []
    for window in np.flatnonzero(close).tolist():
        first, last = max(0, window - _REACH), min(len(close), window + _REACH + 1)
        if spans and first <= spans[-1][1] + _REACH:
            first = spans.pop()[0]
        spans.append((first, last))
    return spans


def _change(q_rad: Float64, hand: _Hand, rows: list[slice], shapes: Float64) -> Float64 | None:
    """The least smooth change (K, T) that clears one approach; None if 10 degrees do not.

    Gauss-Newton steps on the sum of squared change, its roughness, what is too close and what is out of
    range; of the changes that clear it, the one whose largest angle is smallest.
    """
    weights = np.zeros((shapes.shape[1], len(hand.thumb)))
    quiet = np.asarray(np.kron(roughness(len(weights)), np.eye(len(hand.thumb))), dtype=np.float64)
    best: Float64 | None = None
    for _ in range(_STEPS):
        needs = [
            (np.outer(shapes[(one.start + one.stop) // 2], need.slope).ravel(), need)
            for one in rows
            for need in _needs(q_rad[one], shapes[one] @ weights, hand)
        ]
        change = shapes @ weights
        if not any(need.urgent for _, need in needs):
            best = change
        asked = np.stack([row for row, _ in needs]) if needs else np.zeros((0, weights.size))
        short = np.array([need.short for _, need in needs])
        weight = np.array([need.weight for _, need in needs])
        flat: Float64 = weights.ravel()
        step: Float64 = _least(quiet, asked, short + asked @ flat, weight) - flat
        size = float(np.abs(step).max())
        if (best is not None and size < _STILL_RAD) or float(np.abs(change).max()) > 1.5 * MOST_RAD:
            break
        weights = weights + (step * min(1.0, _STEP_RAD / size)).reshape(weights.shape)
    return best if best is not None and float(np.abs(best).max()) <= MOST_RAD else None


def _least(quiet: Float64, asked: Float64, wanted: Float64, weight: Float64) -> Float64:
    """The quietest weights (W T,) with asked @ weights >= wanted, (R,), by active sets of penalties."""
    active = wanted > 0.0
    weights = np.zeros(len(quiet))
    for _ in range(_SETS):
        pull = (asked[active] * weight[active, None]).T
        weights = np.asarray(
            np.linalg.solve(quiet + pull @ asked[active], pull @ wanted[active]), dtype=np.float64
        )
        again = wanted - asked @ weights > 0.0
        if bool((again == active).all()):
            break
        active = again
    return weights


def _needs(q_rad: Float64, change: Float64, hand: _Hand) -> list[_Need]:
    """What one window of a changed path needs."""
    path = q_rad.copy()
    path[:, hand.thumb] += change
    return [*_too_near(path, hand), *_out_of_range(path, hand)]


def _too_near(path: Float64, hand: _Hand) -> list[_Need]:
    """The need of each finger that the thumb is near to in a window."""
    least = hand.least_m(path)
    if float(least.min()) > _WATCHED_M:
        return []
    slopes = np.zeros((len(_PAIRS), len(hand.thumb)))
    for at, column in enumerate(hand.thumb):
        probed = path.copy()
        probed[:, column] += _PROBE_RAD
        slopes[:, at] = (hand.least_m(probed) - least) / _PROBE_RAD
    return [
        _Need(slopes[pair], _WANTED_M - float(least[pair]), _PER_CLEARANCE, bool(least[pair] < _ENOUGH_M))
        for pair in np.flatnonzero(least <= _WATCHED_M)
    ]


def _out_of_range(path: Float64, hand: _Hand) -> list[_Need]:
    """The need of each thumb joint to stay in its range in a window."""
    found: list[_Need] = []
    for axis, angles, low, high in zip(
        np.eye(len(hand.thumb)), path[:, hand.thumb].T, hand.low_rad, hand.high_rad, strict=True
    ):
        for way, short in ((axis, low - float(angles.min())), (-axis, float(angles.max()) - high)):
            found.append(_Need(way, short, _PER_RANGE, short > 0.5 * INSET * SOFT_RAD))
    return found


def _sentence(change: Float64, names: tuple[str, ...], take_s: Float64) -> str:
    row, joint = divmod(int(np.argmax(np.abs(change))), change.shape[1])
    return (
        f"The thumb was led past the fingers to keep {1e3 * CLEARANCE_M:.0f} mm between their skins: "
        f"{names[joint]} moved by up to {np.rad2deg(abs(change[row, joint])):.1f} deg, at "
        f"{take_s[row]:.1f} s of the take."
    )


def _refusal(take_s: Float64, rows: list[slice], least: Float64) -> str:
    window, pair = divmod(int(np.argmin(least)), least.shape[1])
    return (
        f"{_PAIRS[pair].capitalize()} comes to {1e3 * least[window, pair]:.1f} mm at "
        f"{take_s[rows[window].start]:.1f} s of the take: keeping {1e3 * CLEARANCE_M:.0f} mm would need more "
        f"than {np.rad2deg(MOST_RAD):.0f} deg of the thumb, so that the movement was left as shown."
    )
