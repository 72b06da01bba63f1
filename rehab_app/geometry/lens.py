"""What a lens does to a pinhole image: the radial and tangential model that calibration programs share."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np

from rehab_app.geometry.pinhole import Intrinsics
from sessions.errors import Refused
from sessions.records.fields import Float64

COUNTS = (0, 4, 5, 8)
"""How many coefficients a lens may have: none, k1 k2 p1 p2, with k3, with k4 k5 k6."""
_LARGEST = 1e4  # no lens has such a coefficient; a file that is no calibration soon does


@dataclass(frozen=True, slots=True)
class Lens:
    """Distortion coefficients k1 k2 p1 p2 [k3 [k4 k5 k6]] of the Brown-Conrady model, in OpenCV's order.

    Attributes:
        coefficients: None for a lens without distortion, else 4, 5 or 8.

    Raises:
        Refused: Another number of them, or one that is not finite or absurd.
    """

    coefficients: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        if len(self.coefficients) not in COUNTS:
            raise Refused(
                "lens distortion", f"{len(self.coefficients)} coefficients", "0, 4, 5 or 8", "calibrate again"
            )
        worst = max(self.coefficients, key=lambda value: abs(np.nan_to_num(value, nan=np.inf)), default=0.0)
        if not abs(worst) < _LARGEST:
            raise Refused(
                "lens distortion",
                f"a coefficient of {worst:g}",
                f"finite and below {_LARGEST:g}",
                "calibrate again",
            )

    @property
    def straight(self) -> bool:
        """Whether straight lines stay straight."""
        return not any(self.coefficients)

    @property
    def vector(self) -> Float64:
        """The coefficients as the library wants them, shape (5,) or (8,)."""
        padded = [*self.coefficients, *[0.0] * (5 - len(self.coefficients))]
        return np.asarray(padded, dtype=np.float64)

    def undistorted(self, pixel_px: Float64, intrinsics: Intrinsics) -> Float64:
        """Where pixels of the raw image lie in the pinhole image of the same intrinsics.

        Args:
            pixel_px: Raw pixels u v, shape (N, 2).
            intrinsics: The pinhole camera.

        Returns:
            Pixels of the pinhole image, shape (N, 2).
        """
        if self.straight or not len(pixel_px):
            return np.array(pixel_px, dtype=np.float64)
        matrix = camera_matrix(intrinsics)
        points = np.ascontiguousarray(pixel_px, dtype=np.float64).reshape(-1, 1, 2)
        criteria = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 100, 1e-12)
        moved: Any = cv2.undistortPoints(points, matrix, self.vector, None, None, matrix, criteria)
        return moved.reshape(-1, 2)

    def distorted(self, pixel_px: Float64, intrinsics: Intrinsics) -> Float64:
        """Where pixels of the pinhole image lie in the raw image; undoes ``undistorted``.

        Args:
            pixel_px: Pixels of the pinhole image u v, shape (N, 2).
            intrinsics: The pinhole camera.

        Returns:
            Raw pixels, shape (N, 2).
        """
        if self.straight or not len(pixel_px):
            return np.array(pixel_px, dtype=np.float64)
        ray = intrinsics.lift(np.asarray(pixel_px, dtype=np.float64), np.ones(len(pixel_px)))
        moved: Any = cv2.projectPoints(ray, np.zeros(3), np.zeros(3), camera_matrix(intrinsics), self.vector)[
            0
        ]
        return moved.reshape(-1, 2)

    def folds(self, intrinsics: Intrinsics) -> bool:
        """Whether the model turns back within the image, so that two pixels would show one point."""
        corners = np.array([[0.0, 0.0], [intrinsics.width_px - 1.0, intrinsics.height_px - 1.0]])
        rays = intrinsics.lift(corners, np.ones(2))
        farthest = float(np.abs(rays[:, 0]).max() ** 2 + np.abs(rays[:, 1]).max() ** 2) ** 0.5
        radius = np.linspace(0.0, farthest, 200)
        k1, k2, _, _, k3, *rest = self.vector
        k4, k5, k6 = rest or (0.0, 0.0, 0.0)
        s = radius**2
        bent = radius * (1 + s * (k1 + s * (k2 + s * k3))) / (1 + s * (k4 + s * (k5 + s * k6)))
        return bool((np.diff(bent) <= 0).any())


STRAIGHT = Lens()
"""A lens without distortion."""


def camera_matrix(intrinsics: Intrinsics) -> Float64:
    """The 3 x 3 matrix of a pinhole camera, px."""
    return np.array(
        [
            [intrinsics.fx_px, 0.0, intrinsics.cx_px],
            [0.0, intrinsics.fy_px, intrinsics.cy_px],
            [0.0, 0.0, 1.0],
        ]
    )
