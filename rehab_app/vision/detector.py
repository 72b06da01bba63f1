"""The detector by local contrast: blobs of the marker's colour, ring and size tests, depth."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rehab_app.geometry.detections import Detections, lifted
from rehab_app.geometry.pinhole import Intrinsics
from rehab_app.geometry.view import PRIMARY, View
from rehab_app.vision.blobs import Blobs, find_blobs
from rehab_app.vision.colour import ColourModel, named_colour, tint
from rehab_app.vision.contrast import Image, over_surround
from rehab_app.vision.depth_lift import disc_depth, supported
from rehab_app.vision.likeness import likeness
from rehab_app.vision.look import check_sizes, window_about, within_reach
from rehab_app.vision.splitting import split_merged
from sessions.records.fields import Float64

_SURE = 0.6  # similarity of a blob that is kept as a ray though the depth image has a hole there


@dataclass(frozen=True, slots=True)
class DetectorSettings:
    """What a marker looks like.

    Attributes:
        disc_radius_m: Radius of the coloured disc.
        contrast: Lowest centre-surround contrast of the tint; a whole disc in good light has .42.
        surround_px: Width of the surround at a focal length of 525 px, odd.
        colour: Smallest cosine between a blob's chroma and the ink's.
        similarity: Smallest likeness kept.
        depth_gate_m: Greatest distance in depth from the middle of the hand.
        reach_m: Greatest distance from it across the line of sight.
        near_m: Nearest depth considered.
        far_m: Farthest depth considered.
        pixel_std_px: Standard deviation of a centre of a whole, frontal marker along one axis.
    """

    disc_radius_m: float = 0.006
    contrast: float = 0.09
    surround_px: int = 25
    colour: float = 0.6
    similarity: float = 0.1
    depth_gate_m: float = 0.16
    reach_m: float = 0.20
    near_m: float = 0.25
    far_m: float = 2.0
    pixel_std_px: float = 0.08


class ContrastDetector:
    """Finds coloured discs in white rings. Knows nothing of earlier frames but where to look, if told.

    Args:
        colour: Colour of the discs; blue if None.
        settings: What a marker looks like.
    """

    def __init__(self, colour: ColourModel | None = None, settings: DetectorSettings | None = None) -> None:
        self._colour = colour or named_colour("blue")
        self._settings = settings or DetectorSettings()

    def detect(
        self,
        t_capture_ns: int,
        colour_bgr: Image,
        depth_m: NDArray[np.float32] | None,
        intrinsics: Intrinsics,
        around_m: Float64 | None = None,
        view: View = PRIMARY,
    ) -> Detections:
        """Markers in one frame; see ``Detector.detect``."""
        check_sizes(colour_bgr, depth_m, intrinsics)
        top, left, bottom, right = window_about(around_m, intrinsics)
        part = np.s_[top:bottom, left:right]
        colour, depth = colour_bgr[part], None if depth_m is None else depth_m[part]
        surround = 2 * round(0.5 * self._settings.surround_px * intrinsics.fx_px / 525.0 - 0.5) + 1
        tinted = tint(colour, self._colour)
        blobs = find_blobs(
            tinted, over_surround(tinted, surround), self._settings.contrast, self._areas(intrinsics)
        )
        blobs, away, away_std, borne = self._lifted(blobs, depth, intrinsics)
        expected = self._expected_px(away, intrinsics)
        like = likeness(blobs, colour, self._colour, expected, borne, colour=self._settings.colour)
        pixel = blobs.centre_px + np.array([left, top])
        keep = self._kept(pixel, away, like.similarity, intrinsics, has_depth=depth is not None)
        std = self._settings.pixel_std_px * (1.0 + 8.0 * np.maximum(1.0 - like.size[keep], 0.0))
        return lifted(
            t_capture_ns,
            pixel[keep],
            away[keep],
            intrinsics,
            pixel_std_px=std,
            depth_std_m=away_std[keep],
            similarity=like.similarity[keep],
            view=view,
        )

    def _areas(self, intrinsics: Intrinsics) -> tuple[float, float]:
        """Smallest and largest area of a blob that could be a marker at any depth considered, px^2."""
        radius = self._settings.disc_radius_m * intrinsics.fx_px
        return 5.0, 4.0 * np.pi * (radius / self._settings.near_m) ** 2

    def _expected_px(self, depth_m: Float64, intrinsics: Intrinsics) -> Float64:
        """Half axis of a whole disc at some depths, px."""
        return self._settings.disc_radius_m * intrinsics.fx_px / depth_m

    def _lifted(
        self, blobs: Blobs, depth_m: NDArray[np.float32] | None, intrinsics: Intrinsics
    ) -> tuple[Blobs, Float64, Float64, NDArray[np.bool_]]:
        """Blobs, the merged ones apart; depth of each, its std, whether a surface bears it, all (B,)."""
        nothing = np.full(len(blobs), np.nan)
        away, std = (nothing, nothing) if depth_m is None else disc_depth(blobs, depth_m)
        apart = split_merged(blobs, self._expected_px(away, intrinsics), depth_m)
        if depth_m is None:
            nothing = np.full(len(apart), np.nan)
            return apart, nothing, nothing, np.ones(len(apart), dtype=np.bool_)
        if apart is not blobs:
            away, std = disc_depth(apart, depth_m)
        return apart, *supported(apart, depth_m, away, std)

    def _kept(
        self,
        pixel_px: Float64,
        depth_m: Float64,
        similarity: Float64,
        intrinsics: Intrinsics,
        *,
        has_depth: bool,
    ) -> NDArray[np.int64]:
        """Blobs worth keeping: like a marker and, where there is depth, in a hand's reach of most others."""
        likely = similarity > self._settings.similarity
        if not has_depth:
            return np.flatnonzero(likely)
        known = np.isfinite(depth_m)
        with np.errstate(invalid="ignore"):
            sound = likely & (depth_m > self._settings.near_m) & (depth_m < self._settings.far_m)
        likely = sound | (~known & (similarity > _SURE))
        usual = float(np.median(depth_m[sound])) if sound.any() else np.nan
        points = intrinsics.lift(pixel_px, np.where(known, depth_m, usual))
        weight = np.where(sound, similarity, 0.0)
        close = within_reach(points, weight, self._settings.depth_gate_m, self._settings.reach_m)
        return np.flatnonzero(likely & close)
