"""From a predicted hand and one capture to the pairs and the corrected hand: in two passes, doubts last."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rehab_app.hand.marker_model import MarkerModel
from rehab_app.hand.pose_prior import oddity
from rehab_app.tracking.association import NONE, Expected, best_pairs, clear_pairs, pair_costs
from rehab_app.tracking.hand_filter import Estimate, Pairs, Placed, rows_of, unmoved, updated
from rehab_app.tracking.hand_state import HandState
from rehab_app.tracking.sight import Sight
from rehab_app.tracking.visibility import facing_chance, seen_chance
from sessions.records.fields import Float64, Int64

Bool = NDArray[np.bool_]

FEWEST = 4
"""Markers without which a capture says too little of where the hand is."""
_MERGE_PX_M = 0.009  # blobs of markers nearer than this across the ray may have run into one
_WRONG_DEPTH = 5.0  # what a depth may cost that is far off
_WORTH = 12.0  # of a marker that lies exactly where the hand has it, in squared standard deviations


@dataclass(frozen=True, slots=True)
class Followed:
    """The hand after one capture.

    Attributes:
        state: The hand.
        pairs: What it was corrected with.
        after: Its markers.
    """

    state: HandState
    pairs: Pairs
    after: Placed


@dataclass(frozen=True, slots=True)
class Circumstances:
    """What besides the prediction decides about pairs.

    Attributes:
        shown: Probability that each marker is in plain view, shape (M,).
        wobble_m2: Variance of a marker's place on its bone, per axis.
        span_s: Time since the last capture.
        doubt_m2: Variance that a marker's place has beside, for not having been found of late, shape (M,).
        from_behind: Share of the markers that are seen though they face away: 0 of paper, 1 of balls.
        insisted: Markers whose depths are to be believed however far they are from the hand, shape (M,).
    """

    shown: Float64
    wobble_m2: float
    span_s: float
    doubt_m2: Float64
    from_behind: float
    insisted: Bool


def plain(markers: int, wobble_m2: float, span_s: float = 0.0) -> Circumstances:
    """Circumstances of a hand of which nothing special is known."""
    never = np.zeros(markers, dtype=np.bool_)
    return Circumstances(np.ones(markers), wobble_m2, span_s, np.zeros(markers), 0.0, never)


def follow(model: MarkerModel, prior: HandState, sight: Sight, about: Circumstances) -> Followed | None:
    """The hand near where it is expected; None if too little is seen of it."""
    near = unmoved(model, prior)
    first = _pairs(near, sight, about, sure=True)
    if len(np.unique(first.marker)) >= FEWEST:
        near = updated(model, prior, sight, first, about.wobble_m2, about.span_s, near)
    pairs = _pairs(near, sight, about, sure=False)
    if len(np.unique(pairs.marker)) < FEWEST:
        return None
    if np.array_equal(pairs.marker, first.marker) and np.array_equal(pairs.row, first.row):
        return Followed(near.state, pairs, near.placed)
    end = updated(model, prior, sight, pairs, about.wobble_m2, about.span_s, near)
    return Followed(end.state, pairs, end.placed)


def merit(found: Followed, sight: Sight, wobble_m2: float) -> float:
    """What an explanation of a capture is worth: markers found, less their misfit and the posture's oddity.

    Args:
        found: The explanation.
        sight: The capture.
        wobble_m2: Variance of a marker's place on its bone, per axis.
    """
    rows = rows_of(found.after, sight, found.pairs, wobble_m2)
    square = rows.residual_m**2 / rows.variance_m2
    misfit = square[:, :2].sum(axis=1) + np.minimum(square[:, 2], _WRONG_DEPTH)
    return float((_WORTH - np.minimum(misfit, _WORTH)).sum()) - oddity(found.state.joints_rad)


def _pairs(near: Estimate, sight: Sight, about: Circumstances, *, sure: bool) -> Pairs:
    """Pairs of one pass over every camera's detections."""
    markers, state = near.placed, near.state
    beside = (about.wobble_m2 + about.doubt_m2)[:, None, None] * np.eye(3)
    covariance = markers.covariance_m2(state.position_covariance) + beside
    found_marker: list[Int64] = []
    found_row: list[Int64] = []
    for view in sight.views:
        rows = np.flatnonzero(sight.detections.view == view)
        origin = sight.detections.origin_camera_m[rows[0]]
        facing = facing_chance(markers.normals, markers.p_m, origin)
        chance = seen_chance(about.shown, about.from_behind + (1.0 - about.from_behind) * facing)
        cost = pair_costs(Expected(markers.p_m, covariance, chance), sight.of(rows))
        refusal = -2.0 * np.log(1.0 - chance)
        match = clear_pairs(cost, refusal) if sure else best_pairs(cost, refusal)
        marker = np.flatnonzero(match != NONE)
        found_marker.append(marker)
        found_row.append(rows[match[marker]])
    marker = np.concatenate([np.empty(0, np.int64), *found_marker])
    row = np.concatenate([np.empty(0, np.int64), *found_row])
    extra = _merged_m2(markers, sight, marker, row) + about.doubt_m2[marker]
    return Pairs(marker, row, extra, about.insisted[marker])


def _merged_m2(markers: Placed, sight: Sight, marker: Int64, row: Int64) -> Float64:
    """Variance for blobs that may be two markers run into one: a neighbour close by has none of its own."""
    extra = np.zeros(len(marker))
    alone = np.setdiff1d(np.arange(len(markers.p_m)), marker)
    if not alone.size or not marker.size:
        return extra
    apart = markers.p_m[alone][None] - markers.p_m[marker][:, None]
    ray = sight.detections.ray_camera[row][:, None]
    along = (apart * ray).sum(axis=2, keepdims=True)
    square = ((apart - along * ray) ** 2).sum(axis=2)
    nearest = square.min(axis=1)
    return np.where(nearest < _MERGE_PX_M**2, 0.25 * nearest, 0.0)
