"""Palms in a whole image: a single-shot detector on 192 x 192 pixels, its 2016 anchors from a formula."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from rehab_app.vision.markerless.crop import Crop, about_palm, whole_image
from rehab_app.vision.markerless.inference import Inference
from sessions.records.fields import Float64

_GRIDS = ((24, 2), (12, 6))  # cells along each side, anchors in each cell: strides of 8 and 16 pixels
_LIKELY = 0.5  # probability from which a box counts
_SAME = 0.3  # overlap (intersection over union) from which two boxes are one palm
_WRIST, _MIDDLE = 0, 2  # of the detector's seven points


@dataclass(frozen=True, slots=True)
class Palm:
    """One palm.

    Attributes:
        score: Probability, 0 to 1.
        centre_px: Centre of its box, u v.
        side_px: Side of its box.
        points_px: Wrist, knuckles and thumb as the detector sees them, shape (7, 2).
    """

    score: float
    centre_px: Float64
    side_px: float
    points_px: Float64

    @property
    def crop(self) -> Crop:
        """Where the whole hand should be."""
        return about_palm(self.centre_px, self.side_px, self.points_px[_WRIST], self.points_px[_MIDDLE])


class PalmDetector:
    """Finds palms.

    Args:
        network: The palm network.
    """

    def __init__(self, network: Inference) -> None:
        self._network = network
        self._anchors = anchors()

    def __call__(self, image_bgr: NDArray[np.uint8]) -> tuple[Palm, ...]:
        """Palms in an image (H, W, 3), the likeliest first."""
        whole = whole_image(*image_bgr.shape[:2])
        outputs = self._network(whole.cut(image_bgr, self._network.side_px, outside=cv2.BORDER_CONSTANT))
        logit = np.clip(outputs["Identity_1"][:, 0], -100.0, 100.0)
        score = 1.0 / (1.0 + np.exp(-logit))
        likely = np.flatnonzero(score > _LIKELY)
        boxes = outputs["Identity"][likely] / self._network.side_px
        places = boxes.reshape(len(boxes), boxes.shape[1] // 2, 2)
        # row 0 is the centre and rows 2.. are points, all from the anchor; row 1 is the size
        places[:, [0, *range(2, places.shape[1])]] += self._anchors[likely][:, None]
        merged = merge(score[likely], places)
        return tuple(_placed(certainty, place, whole) for certainty, place in merged)


def anchors() -> Float64:
    """Centres of the anchors in shares of the image's side, row by row, shape (2016, 2)."""
    parts: list[Float64] = []
    for cells, repeats in _GRIDS:
        line = (np.arange(cells) + 0.5) / cells
        v, u = np.meshgrid(line, line, indexing="ij")
        parts.append(np.repeat(np.stack([u.ravel(), v.ravel()], axis=1), repeats, axis=0))
    return np.concatenate(parts)


def merge(score: Float64, places: Float64) -> list[tuple[float, Float64]]:
    """Boxes of the same palm as one: their mean, weighted by their scores; the likeliest palm first.

    Args:
        score: Probability of each box, shape (K,).
        places: Centre, size and points of each, shape (K, 2 + P, 2).

    Returns:
        The highest score and the mean place (2 + P, 2) of each palm.
    """
    left = list(np.argsort(-score, kind="stable"))
    palms: list[tuple[float, Float64]] = []
    while left:
        best = left[0]
        same = [row for row in left if row == best or _overlap(places[best], places[row]) > _SAME]
        weight = score[same] / score[same].sum()
        palms.append((float(score[best]), np.einsum("k,kpi->pi", weight, places[same])))
        left = [row for row in left if row not in same]
    return palms


def _overlap(a: Float64, b: Float64) -> float:
    """Intersection over union of two boxes whose first rows are centre and size."""
    low = np.maximum(a[0] - 0.5 * a[1], b[0] - 0.5 * b[1])
    high = np.minimum(a[0] + 0.5 * a[1], b[0] + 0.5 * b[1])
    both = float(np.prod(np.maximum(high - low, 0.0)))
    return both / max(float(np.prod(a[1]) + np.prod(b[1])) - both, 1e-12)


def _placed(score: float, place: Float64, whole: Crop) -> Palm:
    points = whole.to_image(place)
    return Palm(score, points[0], float(place[1].max()) * whole.side_px, points[2:])
