"""A bare hand from frame to frame: found by its palm, then followed by its own landmarks."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from rehab_app.vision.markerless.crop import Crop, about_landmarks
from rehab_app.vision.markerless.inference import Inference
from rehab_app.vision.markerless.networks import LANDMARKS, PALM, load
from rehab_app.vision.markerless.palm import PalmDetector
from sessions.records import Side
from sessions.records.fields import Float64

POINTS = 21
"""Landmarks of a sighting, in the order of the protocol ``mediapipe21``."""

_PRESENT = 0.5  # probability of a hand in the crop from which it counts as one
_MOST_PALMS = 4
_LOOK_ROUND_NS = 1_000_000_000  # how often a followed hand is checked for company


@dataclass(frozen=True, slots=True)
class HandSighting:
    """One hand in one image.

    Attributes:
        t_ns: Capture time, ns.
        pixel_px: The landmarks in the image, u v, shape (21, 2).
        world_m: The same in space as the network guesses them: about the hand's middle, along the camera's
            axes, without a true scale, shape (21, 3).
        score: Probability that there is a hand, 0 to 1.
        right: Probability that it is a right hand, if the image is not mirrored, 0 to 1.
    """

    t_ns: int
    pixel_px: Float64
    world_m: Float64
    score: float
    right: float

    @property
    def looks_like(self) -> Side:
        """The side that the network takes it for."""
        return "right" if self.right >= 0.5 else "left"


class HandLandmarker:
    """Follows one hand through a video.

    Where several hands are in view, it takes up the one that looks like the stated side, then the likeliest.

    Args:
        side: Side of the hand to follow.
        folder: Where the networks lie; the user's cache if None.

    Raises:
        Refused: The networks or the library that runs them are not installed.
    """

    def __init__(self, side: Side, folder: Path | None = None) -> None:
        self._side: Side = side
        self._palms = PalmDetector(Inference(PALM, load(PALM, folder)))
        self._landmarks = Inference(LANDMARKS, load(LANDMARKS, folder))
        self._crop: Crop | None = None
        self._looked_ns: int | None = None
        self.hands = 0

    def observe(self, t_ns: int, colour_bgr: NDArray[np.uint8]) -> HandSighting | None:
        """The hand in the next image (H, W, 3), None where there is none.

        ``hands`` then holds how many were in view when it was last looked round, about once a second.
        """
        followed = None if self._crop is None else self._look(t_ns, colour_bgr, self._crop)
        due = self._looked_ns is None or t_ns - self._looked_ns >= _LOOK_ROUND_NS
        if followed is None or due:
            followed = self._look_round(t_ns, colour_bgr, followed)
        self._crop = None if followed is None else about_landmarks(followed.pixel_px)
        return followed

    def _look_round(
        self, t_ns: int, colour_bgr: NDArray[np.uint8], followed: HandSighting | None
    ) -> HandSighting | None:
        """Search the whole image; a hand that is followed already stays the one."""
        self._looked_ns = t_ns
        others: list[HandSighting] = []
        for palm in self._palms(colour_bgr)[:_MOST_PALMS]:
            known = others if followed is None else [followed, *others]
            if any(_crop_of(one).contains(palm.points_px) for one in known):
                continue
            seen = self._look(t_ns, colour_bgr, palm.crop)
            if seen is not None and not any(_same(seen, one) for one in known):
                others.append(seen)
        self.hands = len(others) + (followed is not None)
        if followed is not None or not others:
            return followed
        return max(others, key=lambda one: (one.looks_like == self._side, one.score))

    def _look(self, t_ns: int, colour_bgr: NDArray[np.uint8], crop: Crop) -> HandSighting | None:
        """The hand within a crop."""
        side_px = self._landmarks.side_px
        outputs = self._landmarks(crop.cut(colour_bgr, side_px, outside=cv2.BORDER_REPLICATE))
        score = float(outputs["Identity_1"][0])
        if score < _PRESENT:
            return None
        share = outputs["Identity"].reshape(POINTS, 3)[:, :2] / side_px
        world = outputs["Identity_3"].reshape(POINTS, 3)
        turned = np.concatenate([world[:, :2] @ crop.axes.T, world[:, 2:]], axis=1)
        return HandSighting(t_ns, crop.to_image(share), turned, score, float(outputs["Identity_2"][0]))


def _crop_of(sighting: HandSighting) -> Crop:
    return about_landmarks(sighting.pixel_px)


def _same(a: HandSighting, b: HandSighting) -> bool:
    """Whether two sightings are of one hand: their middles nearer than half of its size."""
    apart = float(np.linalg.norm(a.pixel_px.mean(axis=0) - b.pixel_px.mean(axis=0)))
    return apart < 0.25 * _crop_of(a).side_px
