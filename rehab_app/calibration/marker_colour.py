"""The colour of the markers, learnt in the light of the room and kept with the camera that sees them."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from rehab_app.calibration.camera import CalibratedCamera, check_size
from rehab_app.cameras.frame import Camera, Colour, Depth, Frame
from rehab_app.errors import Refused
from rehab_app.vision import colour_to_json
from rehab_app.vision.colour_learning import find_colour, learn_colour

_PIXEL = re.compile(r"\s*(\d+(?:\.\d+)?)\s*,\s*(\d+(?:\.\d+)?)\s*")

_PATIENCE_NS = 5_000_000_000


def pixel_named(text: str) -> tuple[float, float]:
    """The pixel that a person types as u,v.

    Raises:
        Refused: The text is no pair of numbers.
    """
    match = _PIXEL.fullmatch(text)
    if match is None:
        raise Refused("--at", repr(text[:40]), "like 320,240", "give the pixel in the middle of a marker")
    return float(match[1]), float(match[2])


def picture_of(path: Path) -> Colour:
    """A colour picture from a file, shape (H, W, 3).

    Raises:
        Refused: The file is not there or no image.
    """
    image: Any = None
    if path.is_file():
        content = np.frombuffer(path.read_bytes(), dtype=np.uint8)
        image = cv2.imdecode(content, cv2.IMREAD_COLOR) if content.size else None
    if image is None:
        value = "no image" if path.is_file() else "not there"
        raise Refused(f"picture {path}", value, "an image file", "check the path")
    return np.asarray(image, dtype=np.uint8)


def frame_of(camera: Camera) -> Frame:
    """The next frame of an open camera; an outage before it is waited for, but not for ever.

    Raises:
        Refused: The camera ends without a frame, or shows none for 5 s.
    """
    first_ns: int | None = None
    for capture in camera.frames():
        if isinstance(capture, Frame):
            return capture
        first_ns = capture.t_ns if first_ns is None else first_ns
        if capture.t_ns - first_ns > _PATIENCE_NS:
            break
    raise Refused("camera", "without a frame", "showing a picture", "check the camera")


def with_colour(
    calibration: CalibratedCamera,
    colour_bgr: Colour,
    depth_m: Depth | None,
    pixel_px: tuple[float, float] | None,
) -> CalibratedCamera:
    """The calibration with the colour of the markers in a picture, as a new version.

    Args:
        calibration: Of the camera that took the picture.
        colour_bgr: The raw picture, shape (H, W, 3).
        depth_m: Its depth, shape (H, W), or None.
        pixel_px: Middle of one marker u v; None to look for the markers.

    Raises:
        Refused: The picture has another resolution, or no marker's colour is there.
    """
    check_size(calibration, colour_bgr.shape[1], colour_bgr.shape[0], "the picture")
    if pixel_px is None:
        model = find_colour(colour_bgr, depth_m, calibration.intrinsics)
    else:
        model = learn_colour(colour_bgr, pixel_px)
    return replace(calibration, colour=colour_to_json(model)).now()
