"""OpenNI 2 cameras (Xtion, PrimeSense, Kinect v1). Needs the extra ``openni`` and its library."""

from __future__ import annotations

import ctypes
import time
from collections.abc import Iterator
from types import TracebackType
from typing import Any

import cv2
import numpy as np

from rehab_app.cameras.device_clock import DeviceClock
from rehab_app.cameras.frame import Colour, Depth, Frame
from rehab_app.cameras.lost import CameraLost, absent, busy, closed
from rehab_app.cameras.openni_library import driver, uris
from rehab_app.cameras.pairing import Image, Pairing
from rehab_app.geometry.pinhole import KINECT, Intrinsics
from sessions.errors import Refused
from sessions.records.fields import UInt8

_WAIT_S = 1.0
_LAST_IMAGE_S = 0.1  # a driver may still hand over the image that it is at when its stream is stopped


class OpenNiCamera:
    """One OpenNI 2 camera, 640 x 480 at 30 Hz if it offers that; depth is registered where it can do so.

    Args:
        device: Its address, or its number among those connected.
        intrinsics: Camera of the colour image; without it, what the device states of its field of view, or
            that of a first-generation RGB-D camera.
    """

    name = "openni"
    has_depth = True

    def __init__(self, device: str | int = 0, intrinsics: Intrinsics | None = None) -> None:
        self._named = device
        self._given = intrinsics
        self._title = f"camera openni:{device}"
        self._intrinsics: Intrinsics | None = intrinsics
        self._rate_hz = 30.0
        self._device: Any = None
        self._streams: dict[str, Any] = {}

    @property
    def intrinsics(self) -> Intrinsics:
        """Camera of the colour image; known once the camera is open.

        Raises:
            Refused: The camera was never open.
        """
        if self._intrinsics is None:
            raise closed()
        return self._intrinsics

    @property
    def rate_hz(self) -> float:
        """Frames per second."""
        return self._rate_hz

    def __enter__(self) -> OpenNiCamera:
        """Start both streams.

        Raises:
            Refused: The extra or its library is missing, or the camera is absent, busy or without depth.
        """
        openni2 = driver()
        try:
            self._device = openni2.Device(self._address().encode())
            self._start(openni2)
        except openni2.OpenNIError as error:
            opened = self._device is not None
            self.__exit__(None, None, None)
            words = str(error).lower()
            raise (busy if opened or "busy" in words or "open failed" in words else absent)(
                self._title
            ) from error
        except Refused:
            self.__exit__(None, None, None)
            raise
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Stop both streams; in this order, because the library does not survive another."""
        streams, self._streams = self._streams, {}
        device, self._device = self._device, None
        for stream in streams.values():
            stream.stop()
        if streams:
            time.sleep(_LAST_IMAGE_S)
        for handle in (*streams.values(), device):
            if handle is not None:
                _close(handle)

    def frames(self) -> Iterator[Frame]:
        """Frames as they come; ``dropped`` by the camera's own frame numbers.

        Raises:
            Refused: The camera is not open.
            CameraLost: It gives nothing any more.
        """
        device = self._device
        if device is None:
            raise closed()
        clock, pairing = DeviceClock(), Pairing(round(0.5e9 / self._rate_hz))
        last: int | None = None
        while self._device is device:
            both = pairing.add(*self._next())
            if both is None:
                continue
            colour, depth = both
            t_ns = clock.monotonic_ns(colour.device_ns, time.monotonic_ns())
            dropped = 0 if last is None else max(colour.number - last - 1, 0)
            yield Frame(t_ns, colour.pixels, self._sized(depth.pixels), self.intrinsics, dropped)
            last = colour.number

    def _address(self) -> str:
        if isinstance(self._named, str):
            return self._named
        found = uris()
        if self._named >= len(found):
            raise absent(self._title)
        return found[self._named]

    def _start(self, openni2: Any) -> None:
        sensors = {"depth": openni2.SENSOR_DEPTH, "colour": openni2.SENSOR_COLOR}
        for kind, sensor in sensors.items():
            if not self._device.has_sensor(sensor):
                raise Refused(self._title, f"without {kind}", "one with colour and depth", "choose another")
        self._register(openni2)
        for kind, sensor in sensors.items():
            self._streams[kind] = self._device.create_stream(sensor)
            self._choose_mode(openni2, kind)
            self._straight(openni2, self._streams[kind])
            self._streams[kind].start()
        mode: Any = self._streams["colour"].get_video_mode()
        self._rate_hz = float(mode.fps)
        self._intrinsics = self._stated(openni2, int(mode.resolutionX), int(mode.resolutionY))

    def _choose_mode(self, openni2: Any, kind: str) -> None:
        """640 x 480 at 30 Hz, or the size of the given intrinsics, where the device offers it."""
        formats = {
            "colour": (openni2.PIXEL_FORMAT_RGB888,),
            "depth": (openni2.PIXEL_FORMAT_DEPTH_1_MM, openni2.PIXEL_FORMAT_DEPTH_100_UM),
        }[kind]
        wanted = self._given or KINECT
        for mode in self._streams[kind].get_sensor_info().videoModes:
            size = (int(mode.resolutionX), int(mode.resolutionY))
            if size == (wanted.width_px, wanted.height_px) and mode.fps == 30 and mode.pixelFormat in formats:
                self._streams[kind].set_video_mode(mode)
                return

    def _register(self, openni2: Any) -> None:
        """Have the device register depth to colour; older ones already do, and cannot be told."""
        mode = openni2.IMAGE_REGISTRATION_DEPTH_TO_COLOR
        if self._device.is_image_registration_mode_supported(mode):
            self._device.set_image_registration_mode(mode)

    def _straight(self, openni2: Any, stream: Any) -> None:
        """Images as the world is, where the device can mirror them."""
        try:
            stream.set_mirroring_enabled(False)
        except openni2.OpenNIError:
            return  # it does not mirror

    def _stated(self, openni2: Any, width_px: int, height_px: int) -> Intrinsics:
        """The given intrinsics, else by the field of view that the device states, else the usual ones."""
        if self._given is not None:
            if (self._given.width_px, self._given.height_px) != (width_px, height_px):
                raise Refused(
                    f"resolution of the camera intrinsics for {self._title}",
                    f"{self._given.width_px} x {self._given.height_px} px",
                    f"{width_px} x {height_px} px, as its images are",
                    "calibrate the camera at this resolution",
                )
            return self._given
        centre = (0.5 * (width_px - 1), 0.5 * (height_px - 1))
        try:
            stream = self._streams["colour"]
            across, down = float(stream.get_horizontal_fov()), float(stream.get_vertical_fov())
            focal = (0.5 * width_px / np.tan(0.5 * across), 0.5 * height_px / np.tan(0.5 * down))
        except openni2.OpenNIError:
            focal = (KINECT.fx_px * width_px / KINECT.width_px,) * 2
        return Intrinsics(float(focal[0]), float(focal[1]), *centre, width_px, height_px)

    def _next(self) -> tuple[str, Image]:
        """The next image of either stream: ``colour`` or ``depth``, and the image."""
        openni2, streams = driver(), dict(self._streams)
        try:
            ready = openni2.wait_for_any_stream(list(streams.values()), _WAIT_S)
            if ready is None:
                raise CameraLost("The OpenNI camera stopped sending: plug it in again.")
            frame: Any = ready.read_frame()
        except openni2.OpenNIError as error:
            raise CameraLost("The OpenNI camera was unplugged: plug it in again.") from error
        kind = "colour" if ready is streams.get("colour") else "depth"
        try:
            pixels = _colour(frame) if kind == "colour" else _depth(openni2, frame)
            return kind, Image(int(frame.frameIndex), 1000 * int(frame.timestamp), pixels)
        finally:
            _close(frame)

    def _sized(self, depth: Depth) -> Depth:
        """Depth at the size of the colour image."""
        size = (self.intrinsics.width_px, self.intrinsics.height_px)
        if depth.shape == size[::-1]:
            return depth
        return np.asarray(cv2.resize(depth, size, interpolation=cv2.INTER_NEAREST), np.float32)


def _colour(frame: Any) -> Colour:
    """A copy of a colour frame's pixels, blue first."""
    rows = _rows(frame)[:, : 3 * frame.width]
    return np.ascontiguousarray(rows.reshape(frame.height, frame.width, 3)[:, :, ::-1])


def _depth(openni2: Any, frame: Any) -> Depth:
    """A copy of a depth frame, m."""
    per_unit = 1e-4 if frame.videoMode.pixelFormat == openni2.PIXEL_FORMAT_DEPTH_100_UM else 1e-3
    rows = np.ascontiguousarray(_rows(frame)[:, : 2 * frame.width])
    return rows.view("<u2").astype(np.float32) * np.float32(per_unit)


def _rows(frame: Any) -> UInt8:
    """A copy of the memory of a frame, row by row, shape (H, bytes of a row)."""
    # the row length follows from the whole: a device opened again states that of its other stream
    return np.frombuffer(ctypes.string_at(frame.data, int(frame.dataSize)), np.uint8).reshape(
        int(frame.height), -1
    )


def _close(handle: Any) -> None:
    try:
        handle.close()
    except driver().OpenNIError:
        return  # unplugged: there is nothing left to close
