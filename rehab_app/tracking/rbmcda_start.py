"""A hand that was lost, or was never named, found among detections with depth or without."""

from __future__ import annotations

import numpy as np

from rehab_app.geometry.detections import Detections
from rehab_app.hand.marker_model import MarkerModel
from rehab_app.tracking.labelling import NONE, label_open_hand, placed_points
from rehab_app.tracking.open_hand import open_shapes
from sessions.records.fields import Float64, Int64

_GATE_M = 0.02
_FIT_M = 0.008
_FIT_AVERAGE_M = 0.012
_MISSING = 0.25  # share of a known person's markers that may be hidden
_MISSING_AVERAGE = 2
_FEWEST = 4


def found_again(
    detections: Detections, model: MarkerModel, last_joints_rad: Float64 | None, *, known: bool
) -> Int64 | None:
    """Detection of each marker of a hand that is held open, or as it was last, shape (M,); None if unseen.

    Args:
        detections: What was seen.
        model: The person with the markers, or an average one.
        last_joints_rad: Angles of the last hand that was fitted, shape (21,).
        known: Whether the model is that of the person, and the detections have depth to compare it with.
    """
    shapes = open_shapes(model)
    if last_joints_rad is not None and bool(np.isfinite(last_joints_rad).all()):
        shapes = np.concatenate([model.positions(last_joints_rad)[None], shapes])
    missing = int(_MISSING * len(model.protocol.names)) if known else _MISSING_AVERAGE
    found = label_open_hand(placed_points(detections), shapes, gate_m=_GATE_M, missing=missing)
    if found is None or found.residual_m > (_FIT_M if known else _FIT_AVERAGE_M):
        return None
    return found.detection if int((found.detection != NONE).sum()) >= _FEWEST else None
