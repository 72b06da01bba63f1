"""The square, turned part of an image that a network looks at, and the way back from it."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from rehab_app.vision.markerless.inference import Picture
from sessions.records.fields import Float64

WRIST, INDEX_MCP, MIDDLE_MCP, RING_MCP = 0, 5, 9, 13
"""Rows of the 21 landmarks that tell how a hand is turned."""

_STEADY = np.array(
    [0, 1, 2, 3, 5, 6, 9, 10, 13, 14, 17, 18]
)  # landmarks that move little when a fist is made
_FROM_PALM = (
    2.6,
    0.5,
)  # the networks were trained on crops so much larger than the palm, so far towards the fingers
_FROM_LANDMARKS = (2.0, 0.1)


@dataclass(frozen=True, slots=True)
class Crop:
    """A square in the image, turned so that the fingers of the hand in it point up.

    Attributes:
        centre_px: Its centre, u v.
        side_px: Its side.
        angle_rad: Turn of its axes against the image's, clockwise as seen.
    """

    centre_px: Float64
    side_px: float
    angle_rad: float

    @property
    def axes(self) -> Float64:
        """Rotation from the crop's axes to the image's, shape (2, 2)."""
        c, s = np.cos(self.angle_rad), np.sin(self.angle_rad)
        return np.array([[c, -s], [s, c]])

    def cut(self, image_bgr: NDArray[np.uint8], side_px: int, *, outside: int) -> Picture:
        """This part of an image as RGB from 0 to 1, shape (side_px, side_px, 3).

        Args:
            image_bgr: The image, shape (H, W, 3).
            side_px: Side of the result.
            outside: What lies beyond the image's edge, a border type of OpenCV.
        """
        scale = self.side_px / side_px
        # pixel centres lie at half of their width: the outer edges of both squares meet
        to_image = scale * self.axes
        middle = self.centre_px - to_image @ np.full(2, 0.5 * (side_px - 1))
        matrix = np.concatenate([to_image, middle[:, None]], axis=1)
        flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        part = cv2.warpAffine(image_bgr, matrix, (side_px, side_px), flags=flags, borderMode=outside)
        return np.ascontiguousarray(part[..., ::-1], dtype=np.float32) / np.float32(255.0)

    def to_image(self, share: Float64) -> Float64:
        """Image pixels of points given in shares of the crop's side from its top left edge, (..., 2)."""
        inner = (share - 0.5) * self.side_px
        return inner @ self.axes.T + self.centre_px

    def contains(self, points_px: Float64) -> bool:
        """Whether the middle of some image points (N, 2) lies within."""
        inner = (points_px.mean(axis=0) - self.centre_px) @ self.axes
        return bool((np.abs(inner) < 0.5 * self.side_px).all())


def whole_image(height_px: int, width_px: int) -> Crop:
    """The smallest square about an image."""
    centre = 0.5 * np.array([width_px - 1.0, height_px - 1.0])
    return Crop(centre, float(max(height_px, width_px)), 0.0)


def about_palm(centre_px: Float64, side_px: float, wrist_px: Float64, middle_px: Float64) -> Crop:
    """The hand to which a palm belongs, from the palm's box and two points on it."""
    return _grown(centre_px, side_px, _upright(middle_px - wrist_px), *_FROM_PALM)


def about_landmarks(pixel_px: Float64) -> Crop:
    """Where the hand will be in the next image, from its 21 landmarks (21, 2) in this one."""
    knuckles = 0.5 * pixel_px[MIDDLE_MCP] + 0.25 * (pixel_px[INDEX_MCP] + pixel_px[RING_MCP])
    angle = _upright(knuckles - pixel_px[WRIST])
    axes = Crop(np.zeros(2), 1.0, angle).axes
    inner = pixel_px[_STEADY] @ axes
    low, high = inner.min(axis=0), inner.max(axis=0)
    return _grown(axes @ (0.5 * (low + high)), float((high - low).max()), angle, *_FROM_LANDMARKS)


def _upright(direction_px: Float64) -> float:
    """Turn that makes a direction in the image point up."""
    return float(np.arctan2(direction_px[0], -direction_px[1]))


def _grown(centre_px: Float64, side_px: float, angle_rad: float, factor: float, shift: float) -> Crop:
    up = np.array([np.sin(angle_rad), -np.cos(angle_rad)])
    return Crop(centre_px + shift * side_px * up, factor * side_px, angle_rad)
