"""From one frame to marker detections: local contrast, blobs, ring and size tests, depth, depth gate."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rehab_app.geometry.detections import Detections
from rehab_app.geometry.pinhole import Intrinsics
from rehab_app.vision.blobs import Blobs, find_blobs
from rehab_app.vision.contrast import Image, centre_surround, chroma
from rehab_app.vision.depth_lift import disc_depth
from rehab_app.vision.ring import ring_share
from sessions.records.fields import Float64


@dataclass(frozen=True, slots=True)
class DetectorSettings:
    """What a marker looks like.

    Attributes:
        disc_radius_m: Radius of the coloured disc.
        contrast: Lowest centre-surround contrast of chroma.
        surround_px: Width of the surround, odd.
        ring: Smallest share of directions in which the white ring is met.
        depth_gate_m: Greatest distance in depth from the middle of all candidates.
        near_m: Nearest depth considered.
        far_m: Farthest depth considered.
        pixel_std_px: Standard deviation of a centre of a whole, frontal marker along one axis.
    """

    disc_radius_m: float = 0.006
    contrast: float = 0.16
    surround_px: int = 25
    ring: float = 0.3
    depth_gate_m: float = 0.16
    near_m: float = 0.25
    far_m: float = 2.0
    pixel_std_px: float = 0.08


class MarkerDetector:
    """Finds blue discs in white rings. Knows nothing of earlier frames but where to look, if told."""

    def __init__(self, settings: DetectorSettings | None = None) -> None:
        self._settings = settings or DetectorSettings()

    def detect(
        self,
        t_capture_ns: int,
        colour_bgr: Image,
        depth_m: NDArray[np.float32],
        intrinsics: Intrinsics,
        around_m: Float64 | None = None,
    ) -> Detections:
        """Markers in one frame.

        Args:
            t_capture_ns: Capture time, ns.
            colour_bgr: Colour image, shape (H, W, 3).
            depth_m: Depth image, shape (H, W).
            intrinsics: Camera of both.
            around_m: Points in the camera frame about which to look (with a wide margin), shape (K, 3); the
                whole image if None.
        """
        top, left, bottom, right = self._window(around_m, intrinsics)
        part = np.s_[top:bottom, left:right]
        colour, depth = colour_bgr[part], depth_m[part]
        tint = chroma(colour)
        response = centre_surround(tint, 3, self._settings.surround_px)
        areas = self._areas(intrinsics)
        blobs = find_blobs(response, np.clip(tint - 0.08, 0.0, None), self._settings.contrast, areas)
        depth_b, depth_std = disc_depth(blobs, depth)
        size, similarity = self._likeness(blobs, depth_b, colour, tint, intrinsics)
        keep = self._gate(depth_b, similarity)
        pixel = blobs.centre_px[keep] + np.array([left, top])
        std = self._settings.pixel_std_px * (1.0 + 8.0 * np.maximum(1.0 - size[keep], 0.0))
        return Detections(
            t_capture_ns,
            pixel,
            intrinsics.lift(pixel, depth_b[keep]),
            intrinsics.lift_covariance(pixel, depth_b[keep], std, depth_std[keep]),
            similarity[keep],
        )

    def _window(self, around_m: Float64 | None, intrinsics: Intrinsics) -> tuple[int, int, int, int]:
        """First row, first column, row after the last, column after the last of the part to look at."""
        whole = (0, 0, intrinsics.height_px, intrinsics.width_px)
        if around_m is None or not len(around_m) or not bool((around_m[:, 2] > 0.1).all()):
            return whole
        pixel = intrinsics.project(around_m)
        margin = 0.06 * intrinsics.fx_px / float(np.median(around_m[:, 2]))
        low, high = np.floor(pixel.min(axis=0) - margin), np.ceil(pixel.max(axis=0) + margin)
        left, right = (int(np.clip(edge, 0, whole[3])) for edge in (low[0], high[0]))
        top, bottom = (int(np.clip(edge, 0, whole[2])) for edge in (low[1], high[1]))
        return (top, left, bottom, right) if right - left > 40 and bottom - top > 40 else whole

    def _areas(self, intrinsics: Intrinsics) -> tuple[float, float]:
        """Smallest and largest area of a blob that could be a marker at any depth considered, px^2."""
        radius = self._settings.disc_radius_m * intrinsics.fx_px
        return 5.0, 4.0 * np.pi * (radius / self._settings.near_m) ** 2

    def _likeness(
        self, blobs: Blobs, depth_m: Float64, colour: Image, tint: NDArray[np.float32], intrinsics: Intrinsics
    ) -> tuple[Float64, Float64]:
        """Size likeness and similarity of each blob, both (B,), 0 to 1.

        A disc keeps the length of its longer axis however it is turned: shorter means partly hidden, longer
        means two markers in one blob.
        """
        expected = self._settings.disc_radius_m * intrinsics.fx_px / depth_m
        ratio = blobs.axes_px[:, 0] / expected
        size = np.exp(-((np.log(np.maximum(ratio, 1e-3)) / 0.45) ** 2))
        half = 0.5 * blobs.box_px[:, 2:4].astype(np.float64)
        ring = ring_share(colour, tint, blobs.centre_px, half)
        ring = np.where(ring >= self._settings.ring, ring, 0.0)
        return size, np.where(np.isfinite(depth_m), size * np.sqrt(np.minimum(ring / 0.8, 1.0)), 0.0)

    def _gate(self, depth_m: Float64, similarity: Float64) -> NDArray[np.int64]:
        """Blobs worth keeping: like a marker, and near the depth of most others."""
        likely = (similarity > 0.1) & (depth_m > self._settings.near_m) & (depth_m < self._settings.far_m)
        if not bool(likely.any()):
            return np.empty(0, np.int64)
        middle = np.median(depth_m[likely])
        return np.flatnonzero(likely & (np.abs(depth_m - middle) < self._settings.depth_gate_m))
