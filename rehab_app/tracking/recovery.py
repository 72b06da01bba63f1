"""A digit that went astray while it was hidden is looked for among the detections that nobody explains.

Once a hidden finger is expected in a wrong posture, its markers stay outside every gate when they show again.
A coarse grid of its postures is laid over the free detections; the most promising ones are handed to the
filter, which decides by how many markers more they explain.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from rehab_app.hand.marker_model import MarkerModel
from rehab_app.tracking.following import Circumstances, Followed, follow, merit
from rehab_app.tracking.hand_state import POSITIONS, HandState
from rehab_app.tracking.sight import Sight
from robot_iface.kinematics import DIP_PER_PIP
from sessions.records.fields import Float64, Int64
from sessions.records.names import DIGITS, JOINTS

Bool = NDArray[np.bool_]

_NEAR_M = 0.012  # of a grid posture's marker to a detection, at most
_PROMISING = 3
_GAIN = 14.0  # merit that another posture must add
_GAIN_OF_ONE = 6.0  # and when a single marker has been missing for a while
_SPREAD_RAD = 0.25  # how surely a grid posture is meant
_FEWEST = 2


@dataclass(frozen=True, slots=True)
class Astray:
    """A digit that lacks markers.

    Attributes:
        digit: Index of the digit.
        gain: Merit that another posture must add.
    """

    digit: int
    gain: float


def recovered(
    model: MarkerModel, found: Followed, prior: HandState, sight: Sight, about: Circumstances, stray: Astray
) -> Followed | None:
    """The hand with one digit in another posture that explains more; None if there is none.

    Args:
        model: The person with the markers.
        found: The capture as explained so far.
        prior: The hand as predicted for this capture.
        sight: What was seen.
        about: Circumstances of the capture.
        stray: The digit.
    """
    mine = np.flatnonzero(model.digit == stray.digit)
    taken = found.pairs.row[~np.isin(found.pairs.marker, mine)]
    free = np.setdiff1d(np.arange(len(sight)), taken)
    if len(mine) < _FEWEST or len(free) < _FEWEST:
        return None
    columns = _joints_of(stray.digit)
    postures = _POSTURES[stray.digit]
    merits = [merit(found, sight, about.wobble_m2) + stray.gain]
    results: list[Followed | None] = [None]
    for row in _promising(model, found.state, sight, free, mine, (columns, postures)):
        tried = follow(model, _with(prior, found.state, columns, postures[row]), sight, about)
        if tried is not None:
            results.append(tried)
            merits.append(merit(tried, sight, about.wobble_m2))
    return results[int(np.argmax(merits))]


def astray(model: MarkerModel, found: Followed, sight: Sight, long_missing: Bool) -> list[Astray]:
    """Digits that lack two markers, or one for long, while detections lie about that nobody explains.

    Args:
        model: The person with the markers.
        found: The capture as explained so far.
        sight: What was seen.
        long_missing: Markers that were not found for a while, shape (M,).
    """
    if len(np.setdiff1d(np.arange(len(sight)), found.pairs.row)) == 0:
        return []
    lacking = np.ones(len(model.digit), dtype=np.bool_)
    lacking[found.pairs.marker] = False
    result: list[Astray] = []
    for digit in range(5):
        mine = model.digit == digit
        if int((lacking & mine).sum()) >= _FEWEST:
            result.append(Astray(digit, _GAIN))
        elif bool((lacking & long_missing & mine).any()):
            result.append(Astray(digit, _GAIN_OF_ONE))
    return result


def _promising(
    model: MarkerModel,
    state: HandState,
    sight: Sight,
    free: Int64,
    mine: Int64,
    grid: tuple[Int64, Float64],
) -> Int64:
    """Rows of the grid that lie nearest to free detections, best first; none that explains fewer than two."""
    columns, postures = grid
    joints = np.tile(state.joints_rad, (len(postures), 1))
    joints[:, columns] = postures
    points = model.positions(joints)[:, mine] @ state.rotation.T + state.p_m
    apart = points[:, :, None] - sight.detections.origin_camera_m[free]
    along = np.einsum("gmdi,di->gmd", apart, sight.detections.ray_camera[free])
    square = np.einsum("gmdi,gmdi->gmd", apart, apart) - along**2
    off = along - sight.range_m[free]
    square += np.where(np.isfinite(off), np.minimum(off**2, _NEAR_M**2), 0.25 * _NEAR_M**2)
    nearest = np.minimum(square.min(axis=2), _NEAR_M**2)
    count = (nearest < _NEAR_M**2).sum(axis=1)
    score = nearest.sum(axis=1)
    order = np.argsort(score, kind="stable")
    return order[count[order] >= _FEWEST][:_PROMISING]


def _with(prior: HandState, near: HandState, columns: Int64, posture_rad: Float64) -> HandState:
    """The predicted hand, placed as it was found, with one digit in another posture and little sure of it."""
    joints = near.joints_rad.copy()
    joints[columns] = posture_rad
    rows = np.concatenate([6 + columns, POSITIONS + 6 + columns])
    covariance = prior.covariance.copy()
    covariance[rows], covariance[:, rows] = 0.0, 0.0
    covariance[6 + columns, 6 + columns] = _SPREAD_RAD**2
    rates = POSITIONS + 6 + columns
    covariance[rates, rates] = np.diagonal(prior.covariance)[rates]
    rate = prior.rate.copy()
    rate[6 + columns] = 0.0
    return replace(near, joints_rad=joints, covariance=covariance, rate=rate)


def _joints_of(digit: int) -> Int64:
    """Columns of a digit's joints."""
    return np.flatnonzero([joint.startswith(DIGITS[digit]) for joint in JOINTS])


def _finger_postures() -> Float64:
    """Postures of a finger (mcp flexion, abduction, pip, dip), shape (G, 4), rad."""
    mcp, pip, aside = np.meshgrid(np.arange(-10, 95, 15), np.arange(0, 106, 15), (-10, 0, 10), indexing="ij")
    grid = np.stack([mcp.ravel(), aside.ravel(), pip.ravel(), DIP_PER_PIP * pip.ravel()], axis=1)
    return np.deg2rad(grid.astype(np.float64))


def _thumb_postures() -> Float64:
    """Postures of a thumb (cmc flexion, cmc abduction, mcp flexion, mcp abduction, ip), shape (G, 5), rad."""
    flexion, aside, mcp, ip = np.meshgrid((-10, 8, 26), (-15, 3, 21), (0, 20, 40), (0, 25, 50), indexing="ij")
    flat = [flexion.ravel(), aside.ravel(), mcp.ravel(), np.zeros(flexion.size), ip.ravel()]
    return np.deg2rad(np.stack(flat, axis=1).astype(np.float64))


_POSTURES = (_thumb_postures(), *[_finger_postures()] * 4)
