"""What goes wrong in a level's pictures: false and missing markers, bad depth, light, blur, lost frames."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from rehab_app.cameras.frame import Colour
from rehab_app.cameras.levels import CALM_S, Level, dropped_frames
from rehab_app.cameras.paper_markers import DISC_RADIUS_M, Papers, PlacedMarkers, sound_papers
from rehab_app.cameras.ray_cast import Box
from rehab_app.geometry.pinhole import Intrinsics
from sessions.records.fields import Float64

_OUTLIER_M = (0.02, 0.10)
_AROUND_PX = 40.0
_NEAR_STD_M = 0.03
_FAR_M = (0.45, 1.6)
_SHOWN_SHARE = 0.9
_EXPOSURE_S = 1.0 / 60.0
_BLOCK = 1024  # frames whose loss is drawn at once


@dataclass(frozen=True, slots=True)
class FalseMarkers:
    """Blue spots that are no markers: where they are and what they look like."""

    placed: PlacedMarkers
    papers: Papers


class PictureTrouble:
    """Draws a level's troubles; what befalls a frame depends on the seed and the frame's index only.

    Args:
        level: How bad it is.
        seed: Of everything.
        intrinsics: The camera.
        rate_hz: Frames per second.
        hand_px: Markers of the open hand, about which persistent false ones lie, shape (M, 2).
        hand_m: Mean depth of the open hand.
    """

    def __init__(
        self, level: Level, seed: int, intrinsics: Intrinsics, rate_hz: float, hand_px: Float64, hand_m: float
    ) -> None:
        self._level = level
        self._seed = seed
        self._intrinsics = intrinsics
        self._rate_hz = rate_hz
        rng = np.random.default_rng([seed, 21])
        count = level.persistent
        low, high = hand_px.min(axis=0) - 60.0, hand_px.max(axis=0) + 60.0
        depth = hand_m + rng.uniform(-0.05, 0.12, count)
        self._standing = self._spots(rng.uniform(low, high, (count, 2)), depth, rng)
        self._phase = rng.uniform(0.0, 2.0 * np.pi, 5)

    def dropped(self, index: int) -> bool:
        """Whether the frame never comes."""
        block, row = divmod(index, _BLOCK)
        rng = np.random.default_rng([self._seed, 22, block])
        t_s = (block * _BLOCK + np.arange(_BLOCK)) / self._rate_hz
        return bool(dropped_frames(self._level, t_s, rng)[row])

    def papers(self, index: int, count: int) -> Papers:
        """The markers of a frame: some are missing, some have no depth or a wrong one."""
        rng, level = self._rng(23, index), self._level
        sound = sound_papers(count)
        shown = (rng.random(count) >= level.miss_share) | (index < CALM_S * self._rate_hz)
        wrong = rng.random(count) < level.outlier_share
        error = wrong * rng.uniform(*_OUTLIER_M, count) * rng.choice((-1.0, 1.0), count)
        error[rng.random(count) < level.hole_share] = np.nan
        return Papers(sound.disc_radius_m, sound.ring_radius_m, error, shown)

    def false_markers(self, index: int, hand_px: Float64, hand_m: float) -> FalseMarkers:
        """Blue spots of a frame, half of them in a white ring.

        Args:
            index: The frame.
            hand_px: The markers now, shape (M, 2).
            hand_m: Their mean depth.
        """
        rng = self._rng(24, index)
        anywhere, near = (int(count) for count in rng.poisson(0.5 * self._level.clutter, 2))
        size = np.array([self._intrinsics.width_px - 1.0, self._intrinsics.height_px - 1.0])
        low, high = hand_px.min(axis=0) - _AROUND_PX, hand_px.max(axis=0) + _AROUND_PX
        pixel = [rng.uniform(0.0, size, (anywhere, 2)), rng.uniform(low, high, (near, 2))]
        depth = [rng.uniform(*_FAR_M, anywhere), rng.normal(hand_m, _NEAR_STD_M, near)]
        passing = self._spots(np.concatenate(pixel), np.concatenate(depth), rng)
        return _together(self._standing, passing, rng.random(self._level.persistent) < _SHOWN_SHARE)

    def lit(self, image: Colour, t_s: float) -> Colour:
        """The image in the light of the moment: brightness wavers slowly and flickers, its colour drifts."""
        share = self._level.light_share
        if share == 0.0:
            return image
        slow = np.sin(2.0 * np.pi * 0.13 * t_s + self._phase[0])
        flicker = 0.2 * np.sin(2.0 * np.pi * 7.3 * t_s + self._phase[1])
        drift = 0.25 * np.sin(2.0 * np.pi * 0.07 * t_s + self._phase[2:])
        gain = 1.0 + share * (0.8 * slow + flicker + drift)
        curve = np.clip(np.arange(256)[:, None] * gain, 0.0, 255.0).astype(np.uint8)
        return np.asarray(cv2.LUT(image, curve[None]), np.uint8)

    def blurred(self, image: Colour, box: Box, speed_px_s: Float64) -> None:
        """Smear a part of the image along the hand's motion during the exposure, in place."""
        way = speed_px_s * _EXPOSURE_S
        length = float(np.linalg.norm(way))
        if length < 1.0:
            return
        half = int(np.ceil(0.5 * length))
        kernel = np.zeros((2 * half + 1, 2 * half + 1), np.float32)
        for share in np.linspace(-0.5, 0.5, 4 * half + 1):
            column, row = np.rint(half + share * way).astype(int)
            kernel[row, column] += 1.0
        part = image[box[0] : box[1], box[2] : box[3]]
        if part.size:
            part[:] = cv2.filter2D(part, -1, kernel / kernel.sum())

    def _rng(self, stream: int, index: int) -> np.random.Generator:
        return np.random.default_rng([self._seed, stream, index])

    def _spots(self, pixel_px: Float64, depth_m: Float64, rng: np.random.Generator) -> FalseMarkers:
        """Spots of many sizes facing the camera."""
        count = len(depth_m)
        points = self._intrinsics.lift(pixel_px, depth_m)
        normal = -points / np.maximum(np.linalg.norm(points, axis=1, keepdims=True), 1e-9)
        disc = DISC_RADIUS_M * rng.uniform(0.6, 1.2, count)
        ring = disc * np.where(rng.random(count) < 0.5, 1.0, 1.33)
        sound = Papers(disc, ring, np.zeros(count), np.ones(count, dtype=np.bool_))
        return FalseMarkers(PlacedMarkers(points, normal), sound)


def _together(standing: FalseMarkers, passing: FalseMarkers, shown: NDArray[np.bool_]) -> FalseMarkers:
    """Persistent and passing spots as one set."""
    a, b = standing, passing
    return FalseMarkers(
        PlacedMarkers(
            np.concatenate([a.placed.p_camera_m, b.placed.p_camera_m]),
            np.concatenate([a.placed.normal, b.placed.normal]),
        ),
        Papers(
            np.concatenate([a.papers.disc_radius_m, b.papers.disc_radius_m]),
            np.concatenate([a.papers.ring_radius_m, b.papers.ring_radius_m]),
            np.concatenate([a.papers.depth_error_m, b.papers.depth_error_m]),
            np.concatenate([shown, b.papers.shown]),
        ),
    )
