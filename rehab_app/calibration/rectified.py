"""A camera whose lens has been taken out of its pictures: everything behind it may trust the pinhole."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from types import TracebackType
from typing import Any

import cv2
import numpy as np

from rehab_app.calibration.camera import CalibratedCamera, check_size
from rehab_app.cameras.frame import Camera, Capture, Colour, Depth, Frame
from rehab_app.geometry.lens import camera_matrix
from rehab_app.geometry.pinhole import Intrinsics

_NO_FRACTION = np.empty(0, dtype=np.uint16)  # sampling the nearest pixel needs none


class Rectified:
    """Removes the lens's distortion from colour and depth, and states the calibrated intrinsics.

    The pinhole picture has the size and the camera matrix of the raw one. Depth is registered to colour,
    before and after; it is taken from the nearest pixel, as a mean over an edge would be a place where
    nothing is. What the raw picture did not show is black, and without depth.

    Args:
        camera: The camera itself; entering and leaving this one enters and leaves it.
        calibration: Its calibration.
    """

    def __init__(self, camera: Camera, calibration: CalibratedCamera) -> None:
        self._camera = camera
        self.calibration = calibration
        self._maps = None if calibration.lens.straight else _maps(calibration)

    @property
    def name(self) -> str:
        """What a session file calls this source: the camera's own name."""
        return self._camera.name

    @property
    def intrinsics(self) -> Intrinsics:
        """The calibrated pinhole camera."""
        return self.calibration.intrinsics

    @property
    def rate_hz(self) -> float:
        """Nominal frames per second."""
        return self._camera.rate_hz

    @property
    def has_depth(self) -> bool:
        """Whether frames carry depth."""
        return self._camera.has_depth

    def __enter__(self) -> Rectified:
        """Open the camera; many know their resolution only then.

        Raises:
            Refused: The resolution is not that of the calibration, or as the camera's own.
        """
        self._camera.__enter__()
        try:
            known = self._camera.intrinsics
            check_size(self.calibration, known.width_px, known.height_px, f"camera {self.name}")
        except BaseException as error:
            self._camera.__exit__(type(error), error, error.__traceback__)
            raise
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close the camera."""
        self._camera.__exit__(kind, error, trace)

    def frames(self) -> Iterator[Capture]:
        """The camera's captures, rectified; outages as they are.

        Raises:
            Refused: A frame has another resolution than the calibration, or as the camera's own.
        """
        for capture in self._camera.frames():
            yield self.rectified(capture) if isinstance(capture, Frame) else capture

    def rectified(self, frame: Frame) -> Frame:
        """One frame without distortion.

        Raises:
            Refused: The frame has another resolution than the calibration.
        """
        height_px, width_px = frame.colour_bgr.shape[:2]
        check_size(self.calibration, width_px, height_px, f"a frame of camera {self.name}")
        if self._maps is None:
            return replace(frame, intrinsics=self.intrinsics)
        smooth, nearest = self._maps
        colour: Colour = cv2.remap(frame.colour_bgr, *smooth, cv2.INTER_LINEAR).astype(np.uint8, copy=False)
        depth: Depth | None = None
        if frame.depth_m is not None:
            moved = cv2.remap(frame.depth_m, nearest, _NO_FRACTION, cv2.INTER_NEAREST)
            depth = np.asarray(moved, dtype=np.float32)
        return replace(frame, colour_bgr=colour, depth_m=depth, intrinsics=self.intrinsics)


def rectified(camera: Camera, calibration: CalibratedCamera | None) -> Camera:
    """The camera without distortion; as it is where there is no calibration."""
    return camera if calibration is None else Rectified(camera, calibration)


def _maps(calibration: CalibratedCamera) -> tuple[tuple[Any, Any], Any]:
    """Where each pixel of the pinhole picture lies in the raw one: for smooth and for nearest sampling."""
    matrix = camera_matrix(calibration.intrinsics)
    size = (calibration.intrinsics.width_px, calibration.intrinsics.height_px)
    lens, same = calibration.lens.vector, np.eye(3)
    column, row = cv2.initUndistortRectifyMap(matrix, lens, same, matrix, size, cv2.CV_32FC1)
    smooth: Any = cv2.convertMaps(column, row, cv2.CV_16SC2)
    nearest: Any = cv2.convertMaps(column, row, cv2.CV_16SC2, nninterpolation=True)[0]
    return smooth, nearest
