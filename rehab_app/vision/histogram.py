"""The detector of the thesis: histogram back-projection, connected components, Bhattacharyya similarity.

Thesis, section 4.2.2: the image is thresholded where it is like the reference histogram, white pixels are
joined to blobs, blobs of more than N_p pixels count, and the blob whose histogram is close to the reference
in the sense of the Bhattacharyya coefficient is a marker; its centre is the mean of its pixels. It knows
neither ring nor size. The gate in depth is ours, as for every detector, so that they compare.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from rehab_app.geometry.detections import Detections, lifted
from rehab_app.geometry.pinhole import Intrinsics
from rehab_app.geometry.view import PRIMARY, View
from rehab_app.vision.blobs import Blobs, measured
from rehab_app.vision.colour import BINS, ColourModel, hue_saturation_bins, named_colour
from rehab_app.vision.components import connected_parts
from rehab_app.vision.contrast import Image
from rehab_app.vision.depth_lift import disc_depth, supported
from rehab_app.vision.look import check_sizes, window_about, within_reach
from sessions.errors import Refused
from sessions.records.fields import Float64

_PIXEL_STD_PX = 0.2


@dataclass(frozen=True, slots=True)
class HistogramSettings:
    """What counts as like the reference.

    Attributes:
        likeness: Least back-projection of a white pixel, as a share of the fullest bin.
        least_value: Brightness (0 to 255) below which hue says nothing.
        least_px: N_p: fewest pixels of a blob.
        most_px: Most pixels of a blob.
        similarity: Least Bhattacharyya coefficient of a blob.
        depth_gate_m: Greatest distance in depth from the middle of the hand.
        reach_m: Greatest distance from it across the line of sight.
    """

    likeness: float = 0.06
    least_value: int = 40
    least_px: int = 6
    most_px: int = 2500
    similarity: float = 0.6
    depth_gate_m: float = 0.16
    reach_m: float = 0.20


class HistogramDetector:
    """Finds discs by the histogram of their hue and saturation.

    Args:
        colour: Colour of the discs; blue if None.
        settings: What counts as like it.

    Raises:
        Refused: The colour is black, which has no hue.
    """

    def __init__(self, colour: ColourModel | None = None, settings: HistogramSettings | None = None) -> None:
        self._colour = colour or named_colour("blue")
        self._settings = settings or HistogramSettings()
        if self._colour.darkness > 0:
            thing = f"marker colour {self._colour.name}"
            raise Refused(
                thing, "without a hue", "of some hue for the histogram", "choose the detector contrast"
            )
        shares = self._colour.shares
        self._scaled = np.asarray(shares / shares.max(), np.float32)

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
        blobs = self._blobs(colour)
        similarity = self._similarity(blobs, colour)
        away, away_std = np.full(len(blobs), np.nan), np.full(len(blobs), np.nan)
        pixel = blobs.centre_px + np.array([left, top])
        keep = similarity >= self._settings.similarity
        if depth is not None:
            away, away_std, _ = supported(blobs, depth, *disc_depth(blobs, depth))
            points = intrinsics.lift(pixel, away)
            weight = np.where(keep, similarity, 0.0)
            keep &= within_reach(points, weight, self._settings.depth_gate_m, self._settings.reach_m)
        return lifted(
            t_capture_ns,
            pixel[keep],
            away[keep],
            intrinsics,
            pixel_std_px=np.full(int(keep.sum()), _PIXEL_STD_PX),
            depth_std_m=away_std[keep],
            similarity=similarity[keep],
            view=view,
        )

    def _blobs(self, colour: Image) -> Blobs:
        """Connected pixels that are like the reference."""
        hsv = np.asarray(cv2.cvtColor(colour, cv2.COLOR_BGR2HSV), np.uint8)
        like = np.asarray(cv2.calcBackProject([hsv], [0, 1], self._scaled, [0, 180, 0, 256], 255), np.uint8)
        mask = (like > 255.0 * self._settings.likeness) & (hsv[..., 2] >= self._settings.least_value)
        parts = connected_parts(mask)
        size = np.bincount(parts.owner, minlength=parts.count)
        parts = parts.only((size > self._settings.least_px) & (size < self._settings.most_px))
        return measured(parts, np.ones(len(parts.row)))

    def _similarity(self, blobs: Blobs, colour: Image) -> Float64:
        """Bhattacharyya coefficient of each blob's histogram with the reference, shape (B,)."""
        bins = BINS[0] * BINS[1]
        pixels = colour[blobs.parts.row, blobs.parts.column][None]
        if not len(blobs):
            return np.zeros(0)
        place = blobs.parts.owner * bins + hue_saturation_bins(pixels)[0]
        counts = np.bincount(place, minlength=len(blobs) * bins).reshape(len(blobs), bins)
        own = counts / blobs.area_px[:, None]
        return np.sqrt(own * self._colour.shares.ravel()).sum(axis=1)
