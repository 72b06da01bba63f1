"""The static check of a whole path, before anything moves."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from robot_iface.kinematics import HandGeometry
from robot_iface.motion.clearance import CLEARANCE_M, too_close, whole_hand
from robot_iface.motion.limits import hulls_exceeded
from robot_iface.motion.path import QuinticPath
from robot_iface.types import Float64, Limits

Quantity = Literal["angle", "flexion speed", "extension speed", "common range", "clearance", "closing order"]
HULL_SLACK_RAD = float(np.deg2rad(0.5))
"""A spline through knots on the edge of a hull swings out by less than this between them. The hull ends 5
degrees inside the measured range, and the lowest layer pulls every set-point back into it."""
_ROUNDING = 1e-9
_CHUNK = 20_000
_CLEARANCE_STEP_S = 0.01
"""At this step of time even a fingertip at its speed limit moves by less than 2 mm."""
_ANGULAR: dict[Quantity, str] = {
    "angle": "°",
    "flexion speed": "°/s",
    "extension speed": "°/s",
    "common range": "° outside",
}
_REMEDIES: dict[Quantity, str] = {
    "common range": "measure today's range again or fit the movement to it",
    "clearance": "trim the movement there or close that digit less",
    "closing order": "close the fingers before the thumb",
}


@dataclass(frozen=True, slots=True)
class Violation:
    """The first place where a path leaves the limits.

    Attributes:
        joint: Joint concerned, both joints of a common range, or the digits that come too close.
        quantity: What is out of bounds.
        t_s: Time from the start of the movement at the checked speed.
        value: Value met, rad, rad/s or (clearance) m; extension speeds are given as positive numbers; of a
            common range, how far outside it. NaN for the order of closing.
        bound: Bound that applies, in the same unit.
    """

    joint: str
    quantity: Quantity
    t_s: float
    value: float
    bound: float

    def sentence(self) -> str:
        """The violation as a person reads it, in degrees or millimetres, with what to do about it."""
        remedy = f": {_REMEDIES[self.quantity]}" if self.quantity in _REMEDIES else ""
        if self.quantity == "closing order":
            return f"{self.joint} at {self.t_s:.2f} s, but the thumb must come over the fingers{remedy}"
        if self.quantity == "clearance":
            value, bound, unit = 1e3 * self.value, 1e3 * self.bound, " mm"
        else:
            value, bound = float(np.rad2deg(self.value)), float(np.rad2deg(self.bound))
            unit = _ANGULAR[self.quantity]
        return (
            f"{self.joint} {self.quantity} is {value:.1f}{unit} at {self.t_s:.2f} s, "
            f"bound {bound:.1f}{unit}{remedy}"
        )


def check_path(
    path: QuinticPath, limits: Limits, speed: float, period_s: float, hand: HandGeometry | None = None
) -> Violation | None:
    """The first violation of range, common range, directed speed or clearance along the whole path, or None.

    The path is sampled at every tick of a player that is already at ``speed``, and at its end: between
    knots as well as on them. The real player is never faster, so a path that passes here is within the
    speeds wherever it is played.

    Args:
        path: The path.
        limits: Bounds of the driven joints, in the order of the path.
        speed: Path speed that will be requested.
        period_s: Control period.
        hand: The hand that is moved; None where there is none (a robot that is not worn).

    Returns:
        The earliest violation of range or speed (at one instant, the one that exceeds its bound most); else
        the first of a common range; else the first of clearance or of the order of closing.
    """
    step = speed * period_s
    samples = int(np.ceil(path.duration_s / step))
    for first in range(0, samples + 1, _CHUNK):
        ticks = np.arange(first, min(first + _CHUNK, samples + 1), dtype=np.float64)
        path_s = np.minimum(ticks * step, path.duration_s)
        found = _first_in(path, limits, speed, path_s)
        if found is not None:
            return found
    return _first_outside_hulls(path, limits, speed) or _first_too_close(path, speed, hand)


def _first_outside_hulls(path: QuinticPath, limits: Limits, speed: float) -> Violation | None:
    """First place where two joints leave the range that they share."""
    if not limits.hulls:
        return None
    path_s = _close_steps(path, speed)
    beyond = hulls_exceeded(path.sample(path_s), path.joint_names, limits.hulls)
    bad = beyond.max(axis=1) > HULL_SLACK_RAD
    if not bool(bad.any()):
        return None
    place = int(np.argmax(bad))
    worst = int(np.argmax(beyond[place]))
    names = " and ".join(limits.hulls[worst].joints)
    value = float(beyond[place, worst])
    return Violation(names, "common range", float(path_s[place]) / speed, value, HULL_SLACK_RAD)


def _first_too_close(path: QuinticPath, speed: float, hand: HandGeometry | None) -> Violation | None:
    """First place where thumb, fingers and palm come too close."""
    if hand is None:
        return None
    path_s = _close_steps(path, speed)
    found = too_close(hand, whole_hand(path.sample(path_s), path.joint_names))
    if found is None:
        return None
    quantity: Quantity = "closing order" if np.isnan(found.value_m) else "clearance"
    return Violation(found.between, quantity, float(path_s[found.place]) / speed, found.value_m, CLEARANCE_M)


def _close_steps(path: QuinticPath, speed: float) -> Float64:
    """Path coordinates that are close in the time of the movement, both ends among them."""
    return np.linspace(0.0, path.duration_s, int(np.ceil(path.duration_s / (speed * _CLEARANCE_STEP_S))) + 1)


def _first_in(path: QuinticPath, limits: Limits, speed: float, path_s: Float64) -> Violation | None:
    """First violation among the sampled coordinates, (n,)."""
    q = path.sample(path_s)
    dq = path.sample(path_s, 1) * speed
    rows: tuple[tuple[Quantity, Float64, Float64, float], ...] = (
        ("angle", q, limits.q_max_rad, 1.0),
        ("angle", -q, -limits.q_min_rad, -1.0),
        ("flexion speed", dq, limits.flexion_speed_rad_s, 1.0),
        ("extension speed", -dq, limits.extension_speed_rad_s, 1.0),
    )
    excess = np.stack([value - bound for _, value, bound, _ in rows])
    bad = excess.max(axis=(0, 2)) > _ROUNDING
    if not bool(bad.any()):
        return None
    tick = int(np.argmax(bad))
    row, joint = divmod(int(np.argmax(excess[:, tick])), q.shape[1])
    quantity, value, bound, sign = rows[row]
    return Violation(
        path.joint_names[joint],
        quantity,
        float(path_s[tick]) / speed,
        sign * float(value[tick, joint]),
        sign * float(bound[joint]),
    )
