"""Detections as rays with axes of their own: two across the ray, one along it.

Across a ray the camera measures finely; along it only the depth sensor speaks, often wrongly or not at all.
Everything that compares a marker with a detection does so in these axes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rehab_app.geometry.detections import Detections
from rehab_app.hand.marker_model import cross
from sessions.records.fields import Float64, Int64


@dataclass(frozen=True, slots=True)
class Sight:
    """What one capture showed.

    Attributes:
        detections: The detections themselves, D of them.
        axes: Rows are two axes across each ray and the ray, shape (D, 3, 3).
        range_m: Distance along the ray from its optical centre, NaN without depth, shape (D,).
        range_variance_m2: Variance of that distance, NaN without depth, shape (D,).
        across_rad2: Variance of the direction about each axis across the ray, shape (D,).
    """

    detections: Detections
    axes: Float64
    range_m: Float64
    range_variance_m2: Float64
    across_rad2: Float64

    def __len__(self) -> int:
        """Number of detections."""
        return len(self.range_m)

    @property
    def views(self) -> Int64:
        """The cameras that saw something, rising."""
        return np.unique(self.detections.view)

    def of(self, rows: Int64) -> Sight:
        """Some of the detections."""
        return Sight(
            self.detections.rows(rows),
            self.axes[rows],
            self.range_m[rows],
            self.range_variance_m2[rows],
            self.across_rad2[rows],
        )

    def local(self, p_camera_m: Float64, rows: Int64) -> Float64:
        """Points (N, 3) in the axes of detections ``rows`` (N,), from their optical centres, shape (N, 3)."""
        apart = p_camera_m - self.detections.origin_camera_m[rows]
        return np.asarray((self.axes[rows] @ apart[:, :, None])[..., 0], dtype=np.float64)


def sight(detections: Detections, *, across_scale: float = 1.0) -> Sight:
    """Rays and their axes.

    Args:
        detections: What was seen.
        across_scale: Factor on the stated standard deviation across the rays, learnt from what was seen
            before.
    """
    ray = detections.ray_camera
    # any axis that is not along the ray will do: camera rays lie near z
    helper = np.where(np.abs(ray[:, :1]) < 0.9, np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0]))
    first = cross(ray, helper)
    first = first / np.linalg.norm(first, axis=1, keepdims=True)
    second = cross(ray, first)
    axes = np.stack([first, second, ray], axis=1)
    apart = detections.p_camera_m - detections.origin_camera_m
    variance = (ray[:, None, :] @ detections.covariance_m2 @ ray[:, :, None])[:, 0, 0]
    return Sight(
        detections,
        axes,
        (ray * apart).sum(axis=1),
        variance,
        (across_scale * detections.ray_std_rad) ** 2,
    )
