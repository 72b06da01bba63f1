"""The first Kinect by libfreenect: colour, and depth registered to it. Needs a library of the system only."""

from __future__ import annotations

import ctypes
import time
from collections.abc import Iterator
from types import TracebackType
from typing import Any

import numpy as np

from rehab_app.cameras import freenect_library, kinect_depth
from rehab_app.cameras.device_clock import DeviceClock
from rehab_app.cameras.frame import Colour, Depth, Frame
from rehab_app.cameras.freenect_library import Device, Unusable
from rehab_app.cameras.lost import CameraLost, absent, busy, closed
from rehab_app.cameras.nominal import fitting
from rehab_app.cameras.pairing import Image, Pairing
from rehab_app.geometry.pinhole import KINECT, Intrinsics
from sessions.records.fields import UInt8

_RATE_HZ = 30.0
_TICKS = 2**32
_NS_PER_TICK = 1000.0 / 60.0
_SILENT_NS = 1_000_000_000
_PIXELS = KINECT.width_px * KINECT.height_px
_SHAPE = (KINECT.height_px, KINECT.width_px)


class FreenectCamera:
    """One Kinect of the first generation, 640 x 480 at 30 Hz.

    Args:
        index: Which of those connected.
        intrinsics: Camera of its colour image; without it, what the maker states.

    Raises:
        Refused: The intrinsics are not for 640 x 480.
    """

    name = "kinect"
    has_depth = True
    rate_hz = _RATE_HZ

    def __init__(self, index: int = 0, intrinsics: Intrinsics | None = None) -> None:
        self._title = f"camera kinect:{index}"
        self._index = index
        self._intrinsics = fitting(intrinsics or KINECT, KINECT.width_px, KINECT.height_px, self._title)
        self._device: Device | None = None
        self._came: list[tuple[str, Image]] = []
        self._ticks: int | None = None

    @property
    def intrinsics(self) -> Intrinsics:
        """Camera of the colour image."""
        return self._intrinsics

    def __enter__(self) -> FreenectCamera:
        """Start both streams.

        Raises:
            Refused: The library is missing, or the camera is absent or busy.
        """
        library = freenect_library.load()
        if freenect_library.count(library) <= self._index:
            raise absent(self._title)
        try:
            self._device = Device(library, self._index)
            self._device.start(self._take_colour, self._take_depth)
        except Unusable as error:
            self.__exit__(None, None, None)
            raise busy(self._title) from error
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Stop both streams."""
        device, self._device = self._device, None
        if device is not None:
            device.close()
        self._came.clear()

    def frames(self) -> Iterator[Frame]:
        """Frames as they come; ``dropped`` by the camera's own times.

        Raises:
            Refused: The camera is not open.
            CameraLost: It gives nothing any more.
        """
        device = self._device
        if device is None:
            raise closed()
        clock, pairing = DeviceClock(), Pairing(round(0.5e9 / _RATE_HZ))
        last_ns: int | None = None
        while self._device is device:
            self._listen(device)
            for kind, image in self._taken():
                both = pairing.add(kind, image)
                if both is None or (last_ns is not None and both[0].device_ns <= last_ns):
                    continue
                device_ns = both[0].device_ns
                periods = 1 if last_ns is None else round((device_ns - last_ns) * 1e-9 * _RATE_HZ)
                last_ns = device_ns
                t_ns = clock.monotonic_ns(device_ns, time.monotonic_ns())
                depth = self._depth(device, both[1].pixels)
                yield Frame(t_ns, both[0].pixels, depth, self._intrinsics, max(periods - 1, 0))

    def _listen(self, device: Device) -> None:
        """Wait until at least one image came.

        Raises:
            CameraLost: None comes.
        """
        since_ns = time.monotonic_ns()
        while not self._came:
            try:
                device.turn()
            except Unusable:
                raise CameraLost("The Kinect was unplugged: plug it in again.") from None
            if time.monotonic_ns() - since_ns > _SILENT_NS:
                raise CameraLost("The Kinect stopped sending: check its power supply and plug it in again.")

    def _taken(self) -> list[tuple[str, Image]]:
        came, self._came = self._came, []
        return came

    def _depth(self, device: Device, raw: Any) -> Depth:
        """Depth registered to the colour image, m."""
        if device.registered:
            return raw.astype(np.float32) * np.float32(0.001)
        return kinect_depth.registered(kinect_depth.metres(raw), self._intrinsics)

    def _take_colour(self, address: int, ticks: int) -> None:
        pixels: Colour = _copied(address, 3 * _PIXELS).reshape(*_SHAPE, 3)[:, :, ::-1]
        self._came.append(("colour", self._image(ticks, np.ascontiguousarray(pixels))))

    def _take_depth(self, address: int, ticks: int) -> None:
        self._came.append(
            ("depth", self._image(ticks, _copied(address, 2 * _PIXELS).view("<u2").reshape(_SHAPE)))
        )

    def _image(self, ticks: int, pixels: Any) -> Image:
        """An image with the time that the device's 32-bit counter means; it starts anew every 71 s."""
        if self._ticks is None:
            self._ticks = ticks
        self._ticks += (ticks - self._ticks + _TICKS // 2) % _TICKS - _TICKS // 2
        return Image(0, round(self._ticks * _NS_PER_TICK), pixels)


def _copied(address: int, size: int) -> UInt8:
    """A copy of memory of the library, shape (size,)."""
    return np.frombuffer(ctypes.string_at(address, size), np.uint8)
