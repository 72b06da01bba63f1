"""A video file as a camera without depth: any file that OpenCV reads."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from types import TracebackType

import cv2
import numpy as np

from rehab_app.cameras.frame import Frame
from rehab_app.cameras.lost import closed
from rehab_app.cameras.nominal import fitting
from rehab_app.cameras.quiet import quietly
from rehab_app.geometry.pinhole import Intrinsics
from sessions.errors import Refused

_DEFAULT_RATE_HZ = 30.0
_RATE_MAX_HZ = 1000.0
_COMPLETE_SHARE = 0.9  # containers only estimate their number of frames
_LAST_FRAMES = 5

os.environ.setdefault(
    "OPENCV_FFMPEG_LOGLEVEL", "-8"
)  # a broken file is told of in one sentence, not in codes


class VideoCamera:
    """Plays a video file as fast as its frames are asked for; it ends with the file.

    A frame's time is that which the container states. Where the container states none, or one that does not
    rise, frames follow each other at its nominal rate.

    Args:
        path: The file.
        intrinsics: Camera of its images; without it, one with a usual field of view is assumed.

    Raises:
        Refused: The file is absent, unreadable or without frames, or the intrinsics do not fit its images.
    """

    name = "video-file"
    has_depth = False

    def __init__(self, path: Path, intrinsics: Intrinsics | None = None) -> None:
        self._path = path
        self._capture: cv2.VideoCapture | None = None
        capture = _opened(path)
        try:
            done, image = capture.read()
            if not done:
                raise _unusable(path, "without frames")
            self._rate_hz = _rate_hz(capture)
            self.frame_count = max(int(capture.get(cv2.CAP_PROP_FRAME_COUNT)), 0)
        finally:
            capture.release()
        self.intrinsics_assumed = intrinsics is None
        self._intrinsics = fitting(intrinsics, image.shape[1], image.shape[0], f"video {path.name!r}")

    @property
    def intrinsics(self) -> Intrinsics:
        """Camera of the images, given or assumed."""
        return self._intrinsics

    @property
    def rate_hz(self) -> float:
        """Nominal frames per second."""
        return self._rate_hz

    def __enter__(self) -> VideoCamera:
        """Open the file."""
        self._capture = _opened(self._path)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close the file."""
        if self._capture is not None:
            self._capture.release()
            self._capture = None

    def frames(self) -> Iterator[Frame]:
        """All frames in order, the first at 0 ns.

        Raises:
            Refused: The camera is not open; at its end, that the file is cut short.
        """
        capture = self._capture
        if capture is None:
            raise closed()
        period_ns = round(1e9 / self._rate_hz)
        first_ns: int | None = None
        last_ns: int | None = None
        count = 0
        while self._capture is capture:
            done, image = capture.read()
            if not done:
                self._check_complete(count)
                return
            stated_ns = round(1e6 * capture.get(cv2.CAP_PROP_POS_MSEC))
            first_ns = stated_ns if first_ns is None else first_ns
            t_ns = stated_ns - first_ns
            if last_ns is not None and t_ns <= last_ns:
                t_ns = last_ns + period_ns
            skipped = 0 if last_ns is None else round((t_ns - last_ns) / period_ns) - 1
            yield Frame(t_ns, np.asarray(image, np.uint8), None, self._intrinsics, max(skipped, 0))
            last_ns, count = t_ns, count + 1

    def _check_complete(self, count: int) -> None:
        if count + _LAST_FRAMES < _COMPLETE_SHARE * self.frame_count:
            raise _unusable(self._path, f"cut short ({count} of {self.frame_count} frames are readable)")


def _opened(path: Path) -> cv2.VideoCapture:
    """The file, opened.

    Raises:
        Refused: There is no such file, or it is no video.
    """
    if not path.is_file():
        raise _unusable(path, "a folder" if path.is_dir() else "absent")
    if path.stat().st_size == 0:
        raise _unusable(path, "empty")
    with quietly():
        capture = cv2.VideoCapture(str(path), cv2.CAP_FFMPEG)
    if not capture.isOpened():
        capture.release()
        raise _unusable(path, "not readable as a video")
    return capture


def _rate_hz(capture: cv2.VideoCapture) -> float:
    stated = float(capture.get(cv2.CAP_PROP_FPS))
    return stated if 0.0 < stated <= _RATE_MAX_HZ else _DEFAULT_RATE_HZ


def _unusable(path: Path, what: str) -> Refused:
    bound = "a whole video such as MP4, MKV, AVI or WebM"
    return Refused(f"video {path.name!r}", what, bound, "choose another file, or copy it again")
