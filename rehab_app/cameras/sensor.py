"""What a sensor adds to a perfect picture: noise of colour and depth, rounding, and holes in the depth."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from rehab_app.cameras.frame import Colour, Depth
from rehab_app.cameras.ray_cast import Box

_MARGIN_PX = 96
_STEP_M = 0.001


@dataclass(frozen=True, slots=True)
class NoiseLevel:
    """How much a sensor adds.

    Attributes:
        colour: Standard deviation of a colour value, of 255.
        depth_m: Standard deviation of one pixel's depth at 0.7 m; it grows with the square of the distance.
        hole_share: Share of the depth image without depth; edges of depth lose it besides.
        edge_m: Depth step beyond which both sides of an edge lose their depth; 0 keeps them.
    """

    colour: float = 3.0
    depth_m: float = 0.0012
    hole_share: float = 0.01
    edge_m: float = 0.025


CLEAN = NoiseLevel(0.0, 0.0, 0.0, 0.0)


class Sensor:
    """Adds noise to images of one size; what it adds depends on the seed and the frame's index only."""

    def __init__(self, noise: NoiseLevel, height_px: int, width_px: int, seed: int) -> None:
        self._noise = noise
        self._size = (height_px, width_px)
        self._seed = seed
        rng = np.random.default_rng([seed, 1])
        bank = (height_px + _MARGIN_PX, width_px + _MARGIN_PX)
        colour = rng.standard_normal((*bank, 3), dtype=np.float32) * noise.colour + 128.0
        self._colour: NDArray[np.uint8] = np.clip(np.rint(colour), 0, 255).astype(np.uint8)
        fine = rng.standard_normal(bank, dtype=np.float32)
        # half of the variance is shared by neighbours, as triangulation over a window makes it
        coarse = np.asarray(cv2.GaussianBlur(fine[::-1, ::-1].copy(), (0, 0), 1.5), np.float32)
        self._depth: NDArray[np.float32] = (fine + coarse / coarse.std()) * np.float32(np.sqrt(0.5))
        patches = np.asarray(
            cv2.GaussianBlur(rng.standard_normal(bank, dtype=np.float32), (0, 0), 2.0), np.float32
        )
        self._holes = patches < np.quantile(patches, noise.hole_share)

    def colour(self, image: Colour, index: int) -> Colour:
        """The image with noise, shape (H, W, 3)."""
        if self._noise.colour == 0.0:
            return image
        rows, columns = self._window(index, 0)
        return np.asarray(cv2.addWeighted(image, 1.0, self._colour[rows, columns], 1.0, -128.0), np.uint8)

    def depth(self, image: Depth, index: int, box: Box) -> Depth:
        """The depth with noise in a box, in place; 0 where the sensor sees none. Shape (H, W), m."""
        part = np.s_[box[0] : box[1], box[2] : box[3]]
        depth = image[part]
        rows, columns = self._window(index, 1)
        if self._noise.depth_m > 0.0:
            noise = self._depth[rows, columns][part]
            depth += noise * (depth * depth * np.float32(self._noise.depth_m / 0.49))
            np.rint(depth / np.float32(_STEP_M), out=depth)
            depth *= np.float32(_STEP_M)
        if self._noise.edge_m > 0.0 and depth.size:
            kernel = np.ones((3, 3), np.uint8)
            step = np.asarray(cv2.morphologyEx(depth, cv2.MORPH_GRADIENT, kernel), np.float32)
            depth[step > self._noise.edge_m] = 0.0
        if self._noise.hole_share > 0.0:
            depth[self._holes[rows, columns][part]] = 0.0
        return image

    def _window(self, index: int, stream: int) -> tuple[slice, slice]:
        """A place in the bank of noise: another one for each frame and stream."""
        row, column = np.random.default_rng([self._seed, 2, stream, index]).integers(0, _MARGIN_PX, 2)
        return slice(int(row), int(row) + self._size[0]), slice(int(column), int(column) + self._size[1])
