"""A lost hand found again: postures that it took before, and open ones, laid over what is seen."""

from __future__ import annotations

import numpy as np

from rehab_app.geometry.rotation import rigid_fit
from rehab_app.hand.marker_model import MarkerModel
from rehab_app.tracking.following import Followed, follow, plain
from rehab_app.tracking.hand_filter import Pairs, plain_pairs, updated
from rehab_app.tracking.hand_state import HandState, at_rest
from rehab_app.tracking.labelling import NONE, label_open_hand, placed_points
from rehab_app.tracking.open_hand import open_shapes
from rehab_app.tracking.palm_search import palm_found
from rehab_app.tracking.recovery import astray, recovered
from rehab_app.tracking.sight import Sight
from sessions.records.fields import Float64

FIRST_STD = np.concatenate([np.full(3, 0.1), np.full(3, 0.01), np.full(21, 0.2)])
"""How surely a hand that was just found is known: turn (rad), place (m), joints (rad)."""

_GATE_M = 0.02
_FIT_M = 0.010
_SCALE = (0.95, 1.05)  # the person is known
_FLAT_SCALE = (0.6, 1.6)  # without depth the size tells how far the hand is
_MISSING = 0.35  # share of the markers that may be hidden
_EXPLAINED = 0.5  # share of the markers that a hand found again must account for


def regained(
    model: MarkerModel,
    sight: Sight,
    postures_rad: Float64,
    rotation: Float64 | None,
    wobble_m2: float,
) -> Followed | None:
    """The hand among detections of the tracking camera; None where there is none.

    Args:
        model: The person with the markers.
        sight: What was seen.
        postures_rad: Postures to look for, shape (K, 21).
        rotation: Palm to camera, roughly; None to try all turns and, beside the postures, open hands.
        wobble_m2: Variance of a marker's place on its bone.
    """
    primary = np.flatnonzero(sight.detections.view == 0)
    points = placed_points(sight.detections.rows(primary))
    shapes, joints = model.positions(postures_rad), postures_rad
    if rotation is None:
        opened = open_shapes(model)
        shapes = np.concatenate([shapes, opened])
        joints = np.concatenate([joints, np.zeros((len(opened), postures_rad.shape[1]))])
    depth = bool(np.isfinite(sight.range_m[primary]).any())
    found = label_open_hand(
        points,
        shapes,
        gate_m=_GATE_M,
        missing=int(_MISSING * len(model.anchors)),
        scale=_SCALE if depth else _FLAT_SCALE,
        rotation=rotation,
    )
    if found is None or found.residual_m > _FIT_M:
        return None
    marker = np.flatnonzero(found.detection != NONE)
    pairs = plain_pairs(marker, primary[found.detection[marker]])
    start = _posed(model, sight, pairs, points[found.detection[marker]], joints[found.shape])
    begun = updated(model, start, sight, pairs, wobble_m2, 0.0).state
    about = plain(len(model.anchors), wobble_m2)
    followed = follow(model, begun, sight, about)
    if followed is None or len(np.unique(followed.pairs.marker)) < _EXPLAINED * len(model.anchors):
        return None
    return followed


def regained_by_the_palm(
    model: MarkerModel, sight: Sight, joints_rad: Float64, rotation: Float64, wobble_m2: float
) -> Followed | None:
    """The hand in whatever posture, from the pattern on its back; fingers are laid on what is left.

    Args:
        model: The person with the markers.
        sight: What was seen.
        joints_rad: Posture to begin from, shape (21,).
        rotation: Palm to camera, roughly, shape (3, 3).
        wobble_m2: Variance of a marker's place on its bone.
    """
    primary = np.flatnonzero(sight.detections.view == 0)
    points = placed_points(sight.detections.rows(primary))
    palm = np.flatnonzero(model.digit < 0)
    match = palm_found(points, model.positions(joints_rad)[palm], rotation)
    if match is None:
        return None
    kept = match != NONE
    pairs = plain_pairs(palm[kept], primary[match[kept]])
    start = _posed(model, sight, pairs, points[match[kept]], joints_rad)
    begun = updated(model, start, sight, pairs, wobble_m2, 0.0).state
    about = plain(len(model.anchors), wobble_m2)
    found = follow(model, begun, sight, about)
    if found is None:
        return None
    for stray in astray(model, found, sight, about.insisted):
        found = recovered(model, found, begun, sight, about, stray) or found
    return found


def _posed(
    model: MarkerModel, sight: Sight, pairs: Pairs, points_m: Float64, joints_rad: Float64
) -> HandState:
    """A hand in a posture laid over its markers."""
    template = model.positions(joints_rad)[pairs.marker]
    rotation, p_m = rigid_fit(points_m[None], template, np.ones((1, len(points_m))))
    t_ns = sight.detections.t_capture_ns
    return at_rest(t_ns, rotation[0], p_m[0], joints_rad, np.diag(FIRST_STD**2))
