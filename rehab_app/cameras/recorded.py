"""A recorded session as a camera: the colour and depth images of a session file, as they were captured."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice
from pathlib import Path
from types import TracebackType

import cv2
import numpy as np

from rehab_app.cameras.frame import Colour, Depth, Frame
from rehab_app.cameras.lost import closed
from rehab_app.cameras.nominal import fitting
from rehab_app.geometry.pinhole import Intrinsics
from sessions.errors import Refused
from sessions.records import CameraCalibration, ColourImage, DepthImage
from sessions.records.fields import Int64
from sessions.records.topics import CAMERA_CALIBRATION, CAMERA_COLOUR, CAMERA_DEPTH
from sessions.store import SessionReader

_DEFAULT_RATE_HZ = 30.0
_SPACINGS = 60


class RecordedCamera:
    """Plays the images of a session file, as fast as they are asked for; it ends with its recording.

    Depth belongs to the colour image of the same capture time; a colour image without one has no depth in
    that frame only. Captures that are missing between two frames are counted as dropped.

    Args:
        path: A sealed session that was recorded with consent to images.
        intrinsics: Camera of the images, instead of the one that the session states.

    Raises:
        Refused: The file is no session, holds no images, or states no camera that fits them.
    """

    name = "recorded-session"

    def __init__(self, path: Path, intrinsics: Intrinsics | None = None) -> None:
        self._path = path
        self._reader: SessionReader | None = None
        with SessionReader(path) as reader:
            if not reader.counts.get(CAMERA_COLOUR.name, 0):
                raise Refused(
                    f"session {path.name!r}",
                    "without images",
                    "recorded with images",
                    "record it with consent to images (--consent-images), or choose another file",
                )
            self.source = reader.header.source
            self.frame_count = reader.counts[CAMERA_COLOUR.name]
            self.has_depth = reader.counts.get(CAMERA_DEPTH.name, 0) > 0
            first = next(reader.records(CAMERA_COLOUR))
            stated = intrinsics or _stated(reader)
            height_px, width_px = _decoded(first, path).shape[:2]
            self._intrinsics = fitting(stated, width_px, height_px, f"session {path.name!r}")
            self._rate_hz = _rate_hz(reader)

    @property
    def intrinsics(self) -> Intrinsics:
        """Camera of the images."""
        return self._intrinsics

    @property
    def rate_hz(self) -> float:
        """Frames per second, from the middle spacing of the first captures."""
        return self._rate_hz

    def __enter__(self) -> RecordedCamera:
        """Open the file."""
        self._reader = SessionReader(self._path)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close the file."""
        if self._reader is not None:
            self._reader.__exit__(None, None, None)
            self._reader = None

    def frames(self) -> Iterator[Frame]:
        """All frames in the order of their capture.

        Raises:
            Refused: The camera is not open, or the file is damaged.
        """
        if self._reader is None:
            raise closed()
        depths: Iterator[DepthImage] = self._reader.records(CAMERA_DEPTH)
        waiting = next(depths, None)
        last_ns: int | None = None
        for image in self._reader.records(CAMERA_COLOUR):
            while waiting is not None and waiting.t_ns < image.t_ns:
                waiting = next(depths, None)
            mine = waiting if waiting is not None and waiting.t_ns == image.t_ns else None
            if last_ns is not None and image.t_ns <= last_ns:
                continue  # a camera's frames rise strictly in time
            yield self._frame(image, mine, last_ns)
            last_ns = image.t_ns

    def _frame(self, image: ColourImage, depth: DepthImage | None, last_ns: int | None) -> Frame:
        periods = 1 if last_ns is None else round((image.t_ns - last_ns) * 1e-9 * self._rate_hz)
        colour = _decoded(image, self._path)
        metres = None if depth is None else _metres(depth)
        size = (self._intrinsics.height_px, self._intrinsics.width_px)
        for met in (colour.shape[:2], size if metres is None else metres.shape):
            if met != size:
                raise Refused(
                    f"an image of session {self._path.name!r}",
                    f"{met[1]} x {met[0]} px",
                    f"{size[1]} x {size[0]} px like its first",
                    "record the session again",
                )
        return Frame(image.t_ns, colour, metres, self._intrinsics, max(periods - 1, 0))


def _stated(reader: SessionReader) -> Intrinsics | None:
    """The camera that the session states, None where it states none."""
    record: CameraCalibration | None = next(reader.records(CAMERA_CALIBRATION), None)
    if record is None:
        return None
    matrix = record.camera_matrix_px
    return Intrinsics(
        float(matrix[0, 0]),
        float(matrix[1, 1]),
        float(matrix[0, 2]),
        float(matrix[1, 2]),
        record.width_px,
        record.height_px,
    )


def _rate_hz(reader: SessionReader) -> float:
    """Frames per second by the middle spacing of the first images."""
    first = islice(reader.records(CAMERA_COLOUR), _SPACINGS + 1)
    t_ns: Int64 = np.array([image.t_ns for image in first], np.int64)
    spacing_ns = float(np.median(np.diff(t_ns))) if len(t_ns) > 1 else 0.0
    return 1e9 / spacing_ns if spacing_ns > 0.0 else _DEFAULT_RATE_HZ


def _decoded(image: ColourImage, path: Path) -> Colour:
    """The colour image, shape (H, W, 3).

    Raises:
        Refused: Its bytes are no image.
    """
    try:
        colour = cv2.imdecode(image.encoded, cv2.IMREAD_COLOR) if image.encoded.size else None
    except cv2.error:
        colour = None
    if colour is None:
        raise Refused(
            f"an image of session {path.name!r}", "not readable", "JPEG or PNG", "record the session again"
        )
    return np.asarray(colour, np.uint8)


def _metres(depth: DepthImage) -> Depth:
    return depth.depth_mm.astype(np.float32) * np.float32(0.001)
