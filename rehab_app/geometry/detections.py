"""What was seen at one instant: blobs as rays, in space where there is depth, but without names yet."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rehab_app.geometry.pinhole import Intrinsics
from rehab_app.geometry.view import PRIMARY, View
from sessions.records.fields import Float64, Int64


@dataclass(frozen=True, slots=True)
class Detections:
    """The marker candidates of one capture, in no particular order, of one camera or of several.

    Every detection is a ray from an optical centre; where the camera gave depth, it is a point as well. All
    coordinates are those of the tracking camera (the first, where there are several).

    Attributes:
        t_capture_ns: Capture time, monotonic, ns.
        pixel_px: Sub-pixel centres u v in the image of the camera that saw it, shape (D, 2).
        p_camera_m: Points, NaN without depth, shape (D, 3).
        covariance_m2: Covariance of each point, NaN without depth, shape (D, 3, 3).
        similarity: Likeness to the marker model, 0 to 1, shape (D,).
        origin_camera_m: Optical centre from which each was seen, shape (D, 3).
        ray_camera: Unit direction in which it was seen, shape (D, 3).
        ray_std_rad: Standard deviation of that direction about each axis across it, shape (D,).
        view: Index of the camera that saw it, shape (D,).
    """

    t_capture_ns: int
    pixel_px: Float64
    p_camera_m: Float64
    covariance_m2: Float64
    similarity: Float64
    origin_camera_m: Float64
    ray_camera: Float64
    ray_std_rad: Float64
    view: Int64

    def __len__(self) -> int:
        """Number of detections."""
        return len(self.pixel_px)

    def rows(self, chosen: Int64) -> Detections:
        """Some of the detections, in the order of ``chosen``."""
        return Detections(
            self.t_capture_ns,
            self.pixel_px[chosen],
            self.p_camera_m[chosen],
            self.covariance_m2[chosen],
            self.similarity[chosen],
            self.origin_camera_m[chosen],
            self.ray_camera[chosen],
            self.ray_std_rad[chosen],
            self.view[chosen],
        )


def lifted(
    t_capture_ns: int,
    pixel_px: Float64,
    depth_m: Float64,
    intrinsics: Intrinsics,
    *,
    pixel_std_px: Float64,
    depth_std_m: Float64,
    similarity: Float64,
    view: View = PRIMARY,
) -> Detections:
    """Detections of one camera from its pixels and depths.

    Args:
        t_capture_ns: Capture time, monotonic, ns.
        pixel_px: Centres u v, shape (D, 2).
        depth_m: Depth along the optical axis, NaN where there is none, shape (D,).
        intrinsics: The camera.
        pixel_std_px: Standard deviation of u and of v, shape (D,).
        depth_std_m: Standard deviation of the depth, shape (D,).
        similarity: Likeness to the marker model, shape (D,).
        view: Where the camera stands.
    """
    turn = view.rotation_tracking_camera
    ray = intrinsics.lift(pixel_px, np.ones(len(pixel_px)))
    length = np.linalg.norm(ray, axis=1)
    focal_px = np.sqrt(intrinsics.fx_px * intrinsics.fy_px)
    points = intrinsics.lift(pixel_px, depth_m)
    covariance = intrinsics.lift_covariance(pixel_px, depth_m, pixel_std_px, depth_std_m)
    return Detections(
        t_capture_ns,
        pixel_px,
        points @ turn.T + view.p_tracking_camera_m,
        turn @ covariance @ turn.T,
        similarity,
        np.broadcast_to(view.p_tracking_camera_m, points.shape),
        (ray / length[:, None]) @ turn.T,
        pixel_std_px / (focal_px * length),
        np.full(len(pixel_px), view.index, dtype=np.int64),
    )


def joined(parts: Sequence[Detections]) -> Detections:
    """What several cameras saw at about the same time as one set; its time is that of the first part."""
    return Detections(
        parts[0].t_capture_ns,
        np.concatenate([part.pixel_px for part in parts]),
        np.concatenate([part.p_camera_m for part in parts]),
        np.concatenate([part.covariance_m2 for part in parts]),
        np.concatenate([part.similarity for part in parts]),
        np.concatenate([part.origin_camera_m for part in parts]),
        np.concatenate([part.ray_camera for part in parts]),
        np.concatenate([part.ray_std_rad for part in parts]),
        np.concatenate([part.view for part in parts]),
    )
