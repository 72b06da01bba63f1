"""Draws one instant of a hand scene as colour and depth."""

from __future__ import annotations

import cv2
import numpy as np

from rehab_app.cameras.frame import Colour, Depth
from rehab_app.cameras.paper_markers import Papers, draw, sound_papers
from rehab_app.cameras.picture_trouble import PictureTrouble
from rehab_app.cameras.ray_cast import Box, SurfaceImage, cast
from rehab_app.cameras.scene import HandScene, PosedHand, seen_from
from rehab_app.cameras.sensor import NoiseLevel, Sensor
from rehab_app.geometry.pinhole import Intrinsics
from rehab_app.geometry.view import PRIMARY, View
from sessions.records.fields import Float64

_SKIN_BGR = np.array([118.0, 152.0, 205.0], dtype=np.float32)
_LIGHT = np.array([-0.30, -0.55, -0.78]) / np.sqrt(0.30**2 + 0.55**2 + 0.78**2)
_WALL_M = 1.35
_STEP_S = 1.0 / 60.0  # over which the speed of the hand is taken
_SPOT_MARGIN_PX = 45  # beyond the hand, where false markers near it lie
_BLUR_MARGIN_PX = 15


class Renderer:
    """Turns postures into pictures; holds the background and the sensor.

    Args:
        scene: Hand, markers and movement.
        noise: What the sensor adds.
        intrinsics: The camera.
        seed: Of noise and background.
        view: Where the camera stands.
        trouble: What else goes wrong, if anything.
    """

    def __init__(
        self,
        scene: HandScene,
        noise: NoiseLevel,
        intrinsics: Intrinsics,
        seed: int,
        *,
        view: View = PRIMARY,
        trouble: PictureTrouble | None = None,
    ) -> None:
        self._scene = scene
        self._intrinsics = intrinsics
        self._view = view
        self._trouble = trouble
        size = (intrinsics.height_px, intrinsics.width_px)
        self._sensor = Sensor(noise, *size, seed)
        self._wall = _wall_paper(*size, np.random.default_rng([seed, 0]))
        self._wall_depth: Depth = np.full(size, _WALL_M, dtype=np.float32)
        self._sensor.depth(self._wall_depth, 0, (0, size[0], 0, size[1]))

    def at(self, t_s: float) -> PosedHand:
        """The scene at one instant in this camera's frame."""
        posed = self._scene.at(t_s)
        return posed if self._view is PRIMARY else seen_from(posed, self._view)

    def render(self, index: int, t_s: float) -> tuple[Colour, Depth]:
        """Colour (H, W, 3) and depth (H, W) in m at ``t_s``, with the noise of frame ``index``."""
        colour, depth = self._wall.copy(), self._wall_depth.copy()
        posed = self.at(t_s)
        surface = cast(posed.skin, _LIGHT, self._intrinsics)
        box = surface.box
        part = np.s_[box[0] : box[1], box[2] : box[3]]
        noisy = box if self._trouble is None else _wider(box, _SPOT_MARGIN_PX, self._intrinsics)
        depth[noisy[0] : noisy[1], noisy[2] : noisy[3]] = _WALL_M
        if surface.depth_m.size:
            hand = _shaded(surface, colour[part])
            draw(posed.markers, self._papers(posed, index), surface, hand, _LIGHT, self._intrinsics)
            colour[part] = hand
            depth[part] = np.where(np.isfinite(surface.depth_m), surface.depth_m, _WALL_M)
        if self._trouble is not None:
            colour = self._troubled(self._trouble, posed, colour, depth, index, t_s)
        return self._sensor.colour(colour, index), self._sensor.depth(depth, index, noisy)

    def seen(self, posed: PosedHand, index: int = 0) -> Float64:
        """Share of each marker's disc in view in a frame, without noise, shape (M,)."""
        surface = cast(posed.skin, _LIGHT, self._intrinsics)
        canvas = np.zeros((*surface.depth_m.shape, 3), np.uint8)
        return draw(posed.markers, self._papers(posed, index), surface, canvas, _LIGHT, self._intrinsics)

    def _papers(self, posed: PosedHand, index: int) -> Papers:
        count = len(posed.markers.p_camera_m)
        return sound_papers(count) if self._trouble is None else self._trouble.papers(index, count)

    def _troubled(
        self, trouble: PictureTrouble, posed: PosedHand, colour: Colour, depth: Depth, index: int, t_s: float
    ) -> Colour:
        """False markers drawn, the hand smeared by its motion, and the light as it is just then."""
        points = posed.markers.p_camera_m
        pixel = self._intrinsics.project(points)
        spots = trouble.false_markers(index, pixel, float(points[:, 2].mean()))
        box = (0, self._intrinsics.height_px, 0, self._intrinsics.width_px)
        draw(spots.placed, spots.papers, SurfaceImage(box, depth, depth), colour, _LIGHT, self._intrinsics)
        before = self._intrinsics.project(self.at(max(t_s - _STEP_S, 0.0)).markers.p_camera_m)
        speed = (pixel - before).mean(axis=0) / _STEP_S
        low, high = pixel.min(axis=0).astype(int), pixel.max(axis=0).astype(int) + 1
        hand = _wider((low[1], high[1], low[0], high[0]), _BLUR_MARGIN_PX, self._intrinsics)
        trouble.blurred(colour, hand, speed)
        return trouble.lit(colour, t_s)


def _wider(box: Box, margin_px: int, intrinsics: Intrinsics) -> Box:
    """The box with a margin, within the image."""
    return (
        max(int(box[0]) - margin_px, 0),
        min(int(box[1]) + margin_px, intrinsics.height_px),
        max(int(box[2]) - margin_px, 0),
        min(int(box[3]) + margin_px, intrinsics.width_px),
    )


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
