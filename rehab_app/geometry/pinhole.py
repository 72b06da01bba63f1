"""The pinhole camera: how a point before it becomes a pixel, and a pixel with depth a point."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass

import numpy as np

from sessions.errors import Refused
from sessions.records.fields import Float64


@dataclass(frozen=True, slots=True)
class Intrinsics:
    """Focal lengths, principal point and size of an image without distortion.

    Pixel (0, 0) is the *centre* of the first pixel. The camera frame is OpenCV's: x right, y down, z forward.

    Attributes:
        fx_px: Focal length along u.
        fy_px: Focal length along v.
        cx_px: Principal point, u.
        cy_px: Principal point, v.
        width_px: Image width.
        height_px: Image height.

    Raises:
        Refused: A length or a size is not above 0.
    """

    fx_px: float
    fy_px: float
    cx_px: float
    cy_px: float
    width_px: int
    height_px: int

    def __post_init__(self) -> None:
        smallest = min(self.fx_px, self.fy_px, float(self.width_px), float(self.height_px))
        if not smallest > 0:
            raise Refused("camera intrinsics", f"{smallest:g} px", "above 0 px", "calibrate the camera")

    def project(self, p_camera_m: Float64) -> Float64:
        """Pixels of points before the camera, (..., 3) in m to (..., 2) in px."""
        z = p_camera_m[..., 2]
        u = self.fx_px * p_camera_m[..., 0] / z + self.cx_px
        v = self.fy_px * p_camera_m[..., 1] / z + self.cy_px
        return np.stack([u, v], axis=-1)

    def lift(self, pixel_px: Float64, depth_m: Float64) -> Float64:
        """Points of pixels (..., 2) at depths (...) along the optical axis, (..., 3) in m."""
        x = (pixel_px[..., 0] - self.cx_px) / self.fx_px * depth_m
        y = (pixel_px[..., 1] - self.cy_px) / self.fy_px * depth_m
        return np.stack([x, y, depth_m], axis=-1)

    def lift_covariance(
        self, pixel_px: Float64, depth_m: Float64, pixel_std_px: Float64, depth_std_m: Float64
    ) -> Float64:
        """Covariance of lifted points to first order.

        Args:
            pixel_px: Pixels, shape (N, 2).
            depth_m: Depths, shape (N,).
            pixel_std_px: Standard deviation of u and of v, shape (N,).
            depth_std_m: Standard deviation of the depth, shape (N,).

        Returns:
            Covariance in the camera frame, shape (N, 3, 3), m^2.
        """
        ray = self.lift(pixel_px, np.ones_like(depth_m))
        covariance = ray[:, :, None] * ray[:, None, :] * (depth_std_m**2)[:, None, None]
        covariance[:, 0, 0] += (depth_m * pixel_std_px / self.fx_px) ** 2
        covariance[:, 1, 1] += (depth_m * pixel_std_px / self.fy_px) ** 2
        return covariance

    @property
    def digest(self) -> str:
        """SHA-256 of the six numbers: the calibration that a file names."""
        numbers = (self.fx_px, self.fy_px, self.cx_px, self.cy_px, self.width_px, self.height_px)
        return hashlib.sha256(repr(numbers).encode()).hexdigest()


KINECT = Intrinsics(525.0, 525.0, 319.5, 239.5, 640, 480)
"""What a first-generation RGB-D camera states at 640 x 480."""
