"""Frames as records of the image topics: colour as JPEG, depth in millimetres, the camera once."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import cv2
import numpy as np

from rehab_app.cameras.frame import Colour, Depth, Frame
from sessions.errors import Refused
from sessions.records import CameraCalibration, ColourImage, DepthImage, Topic
from sessions.records.fields import UInt8, UInt16
from sessions.records.topics import CAMERA_CALIBRATION, CAMERA_COLOUR, CAMERA_DEPTH

CAMERA_FRAME = "camera"
JPEG_QUALITY = 92
_MM_PER_M = 1000.0
_FARTHEST_MM = 65535.0


def frame_records(
    frame: Frame, *, calibration: bool = False, quality: int = JPEG_QUALITY
) -> Iterator[tuple[Topic, Any]]:
    """What a session keeps of one frame, in the order in which it is to be written.

    The writer refuses these images unless the session's header says that the person consented.

    Args:
        frame: The frame.
        calibration: Whether to state the camera too; do so with the first frame of a session.
        quality: Of the JPEG, 1 to 100.

    Yields:
        Topic and record, for ``SessionWriter.write``.

    Raises:
        Refused: The image cannot be encoded.
    """
    if calibration:
        yield CAMERA_CALIBRATION, calibration_record(frame)
    yield CAMERA_COLOUR, _colour_record(frame, quality)
    if frame.depth_m is not None:
        depth = DepthImage(
            t_ns=frame.t_capture_ns, frame_id=CAMERA_FRAME, depth_mm=millimetres(frame.depth_m)
        )
        yield CAMERA_DEPTH, depth


def calibration_record(frame: Frame) -> CameraCalibration:
    """The camera of a frame; it holds no image, so that it needs no consent."""
    camera = frame.intrinsics
    matrix = np.array([[camera.fx_px, 0.0, camera.cx_px], [0.0, camera.fy_px, camera.cy_px], [0.0, 0.0, 1.0]])
    return CameraCalibration(
        t_ns=frame.t_capture_ns,
        frame_id=CAMERA_FRAME,
        width_px=camera.width_px,
        height_px=camera.height_px,
        camera_matrix_px=matrix,
    )


def millimetres(depth_m: Depth) -> UInt16:
    """Depth rounded to whole millimetres, shape (H, W); what is unknown, or beyond 65.535 m, is 0."""
    scaled = np.rint(depth_m * np.float32(_MM_PER_M))
    known = np.isfinite(scaled) & (scaled > 0.0) & (scaled <= _FARTHEST_MM)
    return np.where(known, scaled, 0.0).astype(np.uint16)


def _colour_record(frame: Frame, quality: int) -> ColourImage:
    return ColourImage(
        t_ns=frame.t_capture_ns,
        frame_id=CAMERA_FRAME,
        format="jpeg",
        encoded=_jpeg(frame.colour_bgr, quality),
    )


def _jpeg(colour: Colour, quality: int) -> UInt8:
    """The image as a JPEG file, shape (N,); colour at full resolution, because markers are told by it."""
    options = [
        cv2.IMWRITE_JPEG_QUALITY,
        quality,
        cv2.IMWRITE_JPEG_SAMPLING_FACTOR,
        cv2.IMWRITE_JPEG_SAMPLING_FACTOR_444,
    ]
    try:
        done, encoded = cv2.imencode(".jpg", colour, options)
    except cv2.error:
        done, encoded = False, np.empty(0, np.uint8)
    if not done:
        raise Refused("colour image", f"of shape {colour.shape}", "an image", "record from another camera")
    return np.asarray(encoded, np.uint8).ravel()
