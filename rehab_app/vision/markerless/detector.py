"""A bare hand's landmarks behind the detectors' port, and what is odd about the hand in the picture."""

from __future__ import annotations

from collections import deque
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from rehab_app.geometry.detections import Detections, lifted
from rehab_app.geometry.pinhole import Intrinsics
from rehab_app.geometry.view import PRIMARY, View
from rehab_app.vision.markerless.landmarker import HandLandmarker
from rehab_app.vision.markerless.lift import located
from sessions.records import Side
from sessions.records.fields import Float64

_LATELY = 90  # captures that a doubt rests on
_ENOUGH = 30
_MOSTLY = 0.8
_FEW = 10


class BareHandDetector:
    """Finds the 21 landmarks of one bare hand: row i of a view's detections is landmark i of ``mediapipe21``.

    Args:
        side: Side of the hand; never inferred.
        folder: Where the networks lie; the user's cache if None.

    Raises:
        Refused: The networks or the library that runs them are not installed.
    """

    def __init__(self, side: Side, folder: Path | None = None) -> None:
        self._side: Side = side
        self._folder = folder
        self._hands = {0: HandLandmarker(side, folder)}
        self._looks: deque[Side | None] = deque(maxlen=_LATELY)
        self.captures = 0
        self.sightings = 0
        self.contradictions = 0

    def detect(
        self,
        t_capture_ns: int,
        colour_bgr: NDArray[np.uint8],
        depth_m: NDArray[np.float32] | None,
        intrinsics: Intrinsics,
        around_m: Float64 | None = None,
        view: View = PRIMARY,
    ) -> Detections:
        """Landmarks of the hand in one frame, 21 rows in their order, or none where no hand is seen.

        Args:
            t_capture_ns: Capture time, monotonic, ns.
            colour_bgr: Colour image, shape (H, W, 3).
            depth_m: Depth registered to it, shape (H, W); None of a camera without depth: points then
                have the scale that the network guesses, and the covariance of their shape.
            intrinsics: Camera of both.
            around_m: Not needed: the hand is followed in the image.
            view: Where the camera stands.
        """
        if view.index not in self._hands:
            self._hands[view.index] = HandLandmarker(self._side, self._folder)
        seen = self._hands[view.index].observe(t_capture_ns, colour_bgr)
        self._looks.append(None if seen is None else seen.looks_like)
        self.captures += 1
        if seen is None:
            return _nothing(t_capture_ns, intrinsics, view)
        self.sightings += 1
        self.contradictions += seen.looks_like != self._side
        return located(seen, depth_m, intrinsics, view)

    @property
    def contradicted(self) -> bool:
        """Whether nearly all of all sightings look like the other hand."""
        return self.sightings >= _FEW and self.contradictions > _MOSTLY * self.sightings

    def doubt(self) -> str | None:
        """What is odd of late, one sentence for a person; None if nothing is."""
        seen = [side for side in self._looks if side is not None]
        if len(self._looks) >= _ENOUGH and len(seen) < 0.2 * len(self._looks):
            return "No bare hand is seen: show one whole hand, well lit, half a metre to a metre away."
        if len(seen) >= _ENOUGH and sum(side != self._side for side in seen) > _MOSTLY * len(seen):
            return (
                f"The hand looks like a {_other(self._side)} one, {self._side} is stated: state the other "
                "side, or use a picture that is not mirrored."
            )
        if max(hand.hands for hand in self._hands.values()) > 1:
            return "Two hands are in view, one of them is followed: take the other one out of the picture."
        return None


def _other(side: Side) -> Side:
    return "left" if side == "right" else "right"


def _nothing(t_capture_ns: int, intrinsics: Intrinsics, view: View) -> Detections:
    none = np.empty(0)
    return lifted(
        t_capture_ns,
        np.empty((0, 2)),
        none,
        intrinsics,
        pixel_std_px=none,
        depth_std_m=none,
        similarity=none,
        view=view,
    )
