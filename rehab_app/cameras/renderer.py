"""Draws one instant of a hand scene as colour and depth."""

from __future__ import annotations

import cv2
import numpy as np

from rehab_app.cameras.frame import Colour, Depth
from rehab_app.cameras.paper_markers import draw
from rehab_app.cameras.ray_cast import SurfaceImage, cast
from rehab_app.cameras.scene import HandScene, PosedHand
from rehab_app.cameras.sensor import NoiseLevel, Sensor
from rehab_app.geometry.pinhole import Intrinsics
from sessions.records.fields import Float64

_SKIN_BGR = np.array([118.0, 152.0, 205.0], dtype=np.float32)
_LIGHT = np.array([-0.30, -0.55, -0.78]) / np.sqrt(0.30**2 + 0.55**2 + 0.78**2)
_WALL_M = 1.35


class Renderer:
    """Turns postures into pictures; holds the background and the sensor."""

    def __init__(self, scene: HandScene, noise: NoiseLevel, intrinsics: Intrinsics, seed: int) -> None:
        self._scene = scene
        self._intrinsics = intrinsics
        size = (intrinsics.height_px, intrinsics.width_px)
        self._sensor = Sensor(noise, *size, seed)
        self._wall = _wall_paper(*size, np.random.default_rng([seed, 0]))
        self._wall_depth: Depth = np.full(size, _WALL_M, dtype=np.float32)
        self._sensor.depth(self._wall_depth, 0, (0, size[0], 0, size[1]))

    def render(self, index: int, t_s: float) -> tuple[Colour, Depth]:
        """Colour (H, W, 3) and depth (H, W) in m at ``t_s``, with the noise of frame ``index``."""
        colour, depth = self._wall.copy(), self._wall_depth.copy()
        posed = self._scene.at(t_s)
        surface = cast(posed.skin, _LIGHT, self._intrinsics)
        box = surface.box
        part = np.s_[box[0] : box[1], box[2] : box[3]]
        if surface.depth_m.size:
            hand = _shaded(surface, colour[part])
            draw(posed.markers, surface, hand, _LIGHT, self._intrinsics)
            colour[part] = hand
            depth[part] = np.where(np.isfinite(surface.depth_m), surface.depth_m, _WALL_M)
        return self._sensor.colour(colour, index), self._sensor.depth(depth, index, box)

    def seen(self, posed: PosedHand) -> Float64:
        """Share of each marker's disc in view, without noise, shape (M,)."""
        surface = cast(posed.skin, _LIGHT, self._intrinsics)
        canvas = np.zeros((*surface.depth_m.shape, 3), np.uint8)
        return draw(posed.markers, surface, canvas, _LIGHT, self._intrinsics)


def _shaded(surface: SurfaceImage, background: Colour) -> Colour:
    """Skin in its light over the background, shape (h, w, 3)."""
    light = 0.5 + 0.5 * np.clip(surface.shade, 0.0, 1.0)
    skin = (light[..., None] * _SKIN_BGR).astype(np.uint8)
    return np.where(np.isfinite(surface.depth_m)[..., None], skin, background)


def _wall_paper(height_px: int, width_px: int, rng: np.random.Generator) -> Colour:
    """A calm grey wall whose brightness wanders, shape (H, W, 3)."""
    coarse = rng.uniform(-9.0, 9.0, (6, 8)).astype(np.float32)
    wander = np.asarray(cv2.resize(coarse, (width_px, height_px), interpolation=cv2.INTER_CUBIC), np.float32)
    tint = np.array([122.0, 126.0, 130.0], dtype=np.float32)
    return np.clip(wander[..., None] + tint, 0, 255).astype(np.uint8)
