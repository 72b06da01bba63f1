"""The landmarks of one capture, of one camera or of several, as one point each."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rehab_app.geometry.detections import Detections
from sessions.records.fields import Float64, Int64

POINTS = 21
MEASURED = 0.45
"""Similarity from which a landmark counts as seen rather than guessed."""


@dataclass(frozen=True, slots=True)
class LandmarkPoints:
    """The 21 landmarks.

    Attributes:
        p_camera_m: Points in the tracking camera's frame, shape (21, 3).
        covariance_m2: Their covariance, shape (21, 3, 3).
        similarity: How surely each was seen, shape (21,).
        pixel_px: Where the surest camera saw it, shape (21, 2).
        row: Row of that camera's detection, shape (21,).
    """

    p_camera_m: Float64
    covariance_m2: Float64
    similarity: Float64
    pixel_px: Float64
    row: Int64

    @property
    def std_m(self) -> Float64:
        """Standard deviation along each axis, shape (21, 3)."""
        return np.sqrt(np.diagonal(self.covariance_m2, axis1=1, axis2=2))

    @property
    def measured(self) -> NDArray[np.bool_]:
        """Which landmarks were seen, shape (21,)."""
        return np.asarray(self.similarity >= MEASURED, dtype=np.bool_)


def points_of(detections: Detections, *, metric: bool) -> LandmarkPoints:
    """One point per landmark: with depth, the mean of all cameras weighted by their information.

    Args:
        detections: 21 rows of every camera that saw the hand, one camera or more.
        metric: Whether the points have the depth of a sensor; of guessed ones only the surest camera's hold.
    """
    order = np.arange(len(detections)).reshape(-1, POINTS)
    best = int(np.argmax(detections.similarity[order].mean(axis=1)))
    surest = order[np.argmax(detections.similarity[order], axis=0), np.arange(POINTS)]
    if not metric or len(order) == 1:
        rows = order[best]
        return LandmarkPoints(
            detections.p_camera_m[rows],
            detections.covariance_m2[rows],
            detections.similarity[rows],
            detections.pixel_px[rows],
            rows,
        )
    information = np.linalg.inv(detections.covariance_m2[order])
    covariance = np.linalg.inv(information.sum(axis=0))
    pull = (information @ detections.p_camera_m[order][..., None]).sum(axis=0)
    return LandmarkPoints(
        (covariance @ pull)[..., 0],
        covariance,
        detections.similarity[surest],
        detections.pixel_px[surest],
        surest,
    )
