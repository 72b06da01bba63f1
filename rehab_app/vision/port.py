"""The port that every marker detector implements, and the one place that makes them by name."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from rehab_app.geometry.detections import Detections
from rehab_app.geometry.pinhole import Intrinsics
from rehab_app.geometry.view import PRIMARY, View
from rehab_app.hand.protocol import MarkerProtocol
from rehab_app.vision.colour import ColourModel, named_colour
from rehab_app.vision.contrast import Image
from rehab_app.vision.detector import ContrastDetector
from rehab_app.vision.histogram import HistogramDetector
from sessions.errors import Refused
from sessions.records.fields import Float64

DETECTORS = ("contrast", "histogram")
"""Detectors by name: the default, and the one of the thesis."""


class Detector(Protocol):
    """Finds markers in one frame."""

    def detect(
        self,
        t_capture_ns: int,
        colour_bgr: Image,
        depth_m: NDArray[np.float32] | None,
        intrinsics: Intrinsics,
        around_m: Float64 | None = None,
        view: View = PRIMARY,
    ) -> Detections:
        """Markers in one frame, in no particular order.

        Args:
            t_capture_ns: Capture time, monotonic, ns.
            colour_bgr: Colour image, shape (H, W, 3).
            depth_m: Depth registered to it, shape (H, W), 0 or NaN where there is none; None of a camera
                without depth, whose detections are rays with NaN points.
            intrinsics: Camera of both.
            around_m: Points in this camera's frame about which to look (with a wide margin), shape (K, 3);
                the whole image if None.
            view: Where the camera stands; the detections are in the tracking camera's frame.
        """
        ...


def protocol_colour(protocol: MarkerProtocol) -> ColourModel:
    """The model that the colour named in a protocol stands for.

    Raises:
        Refused: The protocol names no colour, several, or one that is not known.
    """
    named = sorted({marker.colour for marker in protocol.markers} - {""})
    where = f"marker protocol {protocol.name}"
    if not named:
        raise Refused(
            where, "without a colour", "of markers that a camera can see", "choose another protocol"
        )
    if len(named) > 1:
        raise Refused(
            where, "of colours " + ", ".join(named), "of one colour", "use one colour for all markers"
        )
    return named_colour(named[0])


def make_detector(name: str = "contrast", colour: ColourModel | str = "blue") -> Detector:
    """A detector by its name.

    Args:
        name: One of DETECTORS.
        colour: What the markers look like: a learnt model, or the name of a colour.

    Raises:
        Refused: There is no such detector or colour.
    """
    model = named_colour(colour) if isinstance(colour, str) else colour
    if name == "contrast":
        return ContrastDetector(model)
    if name == "histogram":
        return HistogramDetector(model)
    raise Refused("detector", repr(name), "one of " + ", ".join(DETECTORS), "choose one of them")
