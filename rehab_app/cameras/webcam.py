"""A webcam through the system's video driver: colour without depth."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from pathlib import Path
from types import TracebackType

import cv2
import numpy as np

from rehab_app.cameras.frame import Frame
from rehab_app.cameras.lost import CameraLost, absent, busy, closed
from rehab_app.cameras.nominal import assumed, fitting
from rehab_app.cameras.quiet import quietly
from rehab_app.geometry.pinhole import Intrinsics
from sessions.errors import Refused

_SIZE_PX = (640, 480)
_RATE_HZ = 30.0
_STALE_NS = 2_000_000_000
_DEVICES = Path("/dev")


class Webcam:
    """One capture device of the system.

    Args:
        index: Its number, as in ``/dev/video0``.
        intrinsics: Camera of its images, whose size is asked for; without it 640 x 480 and a usual field of
            view are assumed.
        size_px: Width and height to ask for where no intrinsics are given.
    """

    name = "webcam"
    has_depth = False

    def __init__(
        self, index: int, intrinsics: Intrinsics | None = None, size_px: tuple[int, int] = _SIZE_PX
    ) -> None:
        self._index = index
        self._given = intrinsics
        self._size_px = (intrinsics.width_px, intrinsics.height_px) if intrinsics else size_px
        self._intrinsics = intrinsics or assumed(*size_px)
        self.intrinsics_assumed = intrinsics is None
        self._capture: cv2.VideoCapture | None = None
        self._rate_hz = _RATE_HZ

    @property
    def intrinsics(self) -> Intrinsics:
        """Camera of the images, given or assumed."""
        return self._intrinsics

    @property
    def rate_hz(self) -> float:
        """Frames per second that the driver states."""
        return self._rate_hz

    def __enter__(self) -> Webcam:
        """Open the device.

        Raises:
            Refused: It is absent or busy, or its images do not have the size of the intrinsics.
        """
        title = f"camera webcam:{self._index}"
        device = _DEVICES / f"video{self._index}"
        if not device.exists():
            raise absent(title)
        if not os.access(device, os.R_OK | os.W_OK):
            remedy = "add yourself to the group video (sudo usermod -aG video $USER) and log in again"
            raise Refused(title, "not yours to read", "readable", remedy)
        capture = _opened(self._index)
        if not capture.isOpened():
            capture.release()
            raise busy(title)
        capture.set(cv2.CAP_PROP_FRAME_WIDTH, self._size_px[0])
        capture.set(cv2.CAP_PROP_FRAME_HEIGHT, self._size_px[1])
        done, image = capture.read()
        if not done:
            capture.release()
            raise busy(title)
        try:
            self._intrinsics = fitting(self._given, image.shape[1], image.shape[0], title)
        except Refused:
            capture.release()
            raise
        stated = float(capture.get(cv2.CAP_PROP_FPS))
        self._rate_hz = stated if 1.0 <= stated <= 240.0 else _RATE_HZ
        self._capture = capture
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close the device."""
        capture, self._capture = self._capture, None
        if capture is not None:
            capture.release()

    def frames(self) -> Iterator[Frame]:
        """Frames as they come; what the driver lost meanwhile is counted by the time between them.

        Raises:
            Refused: The camera is not open.
            CameraLost: It gives nothing any more.
        """
        capture = self._capture
        if capture is None:
            raise closed()
        last_ns: int | None = None
        while self._capture is capture:
            done, image = capture.read()
            if not done:
                raise CameraLost(f"The webcam {self._index} stopped sending: plug it in again.")
            t_ns = _capture_ns(capture)
            if last_ns is not None and t_ns <= last_ns:
                t_ns = last_ns + 1
            periods = 1 if last_ns is None else round((t_ns - last_ns) * 1e-9 * self._rate_hz)
            yield Frame(t_ns, np.asarray(image, np.uint8), None, self._intrinsics, max(periods - 1, 0))
            last_ns = t_ns


def webcam_indices() -> tuple[int, ...]:
    """Numbers of the capture devices of this machine, in order."""
    found = (path.name.removeprefix("video") for path in _DEVICES.glob("video*"))
    return tuple(sorted(int(number) for number in found if number.isdecimal() and _captures(int(number))))


def _captures(index: int) -> bool:
    """Whether a device gives images: one webcam often has a second device for metadata, with index 1."""
    order = Path(f"/sys/class/video4linux/video{index}/index")
    return not order.is_file() or order.read_text().strip() == "0"


def _capture_ns(capture: cv2.VideoCapture) -> int:
    """Time of capture: the driver's, which is monotonic, if it states one that is recent; else now."""
    now_ns = time.monotonic_ns()
    stated_ns = round(1e6 * capture.get(cv2.CAP_PROP_POS_MSEC))
    return stated_ns if now_ns - _STALE_NS < stated_ns <= now_ns else now_ns


def _opened(index: int) -> cv2.VideoCapture:
    """The device, opened or not."""
    with quietly():
        return cv2.VideoCapture(index, cv2.CAP_V4L2)
