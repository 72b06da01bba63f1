"""The library libfreenect by its C interface: what of it a Kinect v1 needs, and no more.

Source: ``libfreenect.h`` of version 0.5. The library is loaded when it is first needed; a stand-in of the
same name (fakenect, which plays recordings) serves where there is no Kinect.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from ctypes import byref, c_int, c_int8, c_int16, c_int32, c_long, c_uint32, c_void_p
from typing import Any

from rehab_app.cameras.lost import missing_library

LIBRARY = "libfreenect.so.0.5"
PACKAGE = "libfreenect0.5"
DEPTH_11_BIT, DEPTH_REGISTERED = 0, 4
_MEDIUM, _VIDEO_RGB = 1, 0
_CAMERA_ONLY = 2
_LOG_FATAL = 0
_TURN_US = 100_000

ImageReceived = Callable[[int, int], None]
"""Takes the address of an image in the library's memory, and its time in ticks of 1/60 us, modulo 2^32."""

_Callback = ctypes.CFUNCTYPE(None, c_void_p, c_void_p, c_uint32)


class _Mode(ctypes.Structure):
    """``freenect_frame_mode``."""

    _fields_ = (
        ("reserved", c_uint32),
        ("resolution", c_uint32),
        ("format", c_int32),
        ("bytes", c_int32),
        ("width", c_int16),
        ("height", c_int16),
        ("data_bits_per_pixel", c_int8),
        ("padding_bits_per_pixel", c_int8),
        ("framerate", c_int8),
        ("is_valid", c_int8),
    )


class _Time(ctypes.Structure):
    """``timeval``."""

    _fields_ = (("s", c_long), ("us", c_long))


class Unusable(Exception):
    """The library could not do what it was asked; the words name the step."""


def load() -> Any:
    """The library.

    Raises:
        Refused: It is not installed.
    """
    try:
        library: Any = ctypes.CDLL(LIBRARY)
    except OSError as error:
        raise missing_library("Kinect", LIBRARY, PACKAGE) from error
    for name in ("freenect_get_depth_mode", "freenect_get_video_mode"):
        getattr(library, name).restype = _Mode
        getattr(library, name).argtypes = [c_int]
    return library


class Device:
    """The cameras of one Kinect, open.

    Args:
        library: From ``load``.
        index: Which Kinect.

    Attributes:
        registered: Whether depth comes in mm and registered to colour; else it comes as 11-bit raw values.

    Raises:
        Unusable: It is absent or in use.
    """

    def __init__(self, library: Any, index: int) -> None:
        self._library = library
        self._context = c_void_p()
        self._device = c_void_p()
        self._kept: list[Any] = []
        self._tell("start USB", library.freenect_init(byref(self._context), None))
        library.freenect_set_log_level(self._context, _LOG_FATAL)
        library.freenect_select_subdevices(self._context, _CAMERA_ONLY)
        try:
            self._tell("open", library.freenect_open_device(self._context, byref(self._device), index))
        except Unusable:
            library.freenect_shutdown(self._context)
            raise
        self.registered = self._choose_depth()

    def start(self, on_colour: ImageReceived, on_depth: ImageReceived) -> None:
        """Start both streams.

        Raises:
            Unusable: A stream does not start.
        """
        video = self._mode("video", _VIDEO_RGB)
        if video is None:
            raise Unusable("find 640 x 480 RGB")
        self._tell("set the colour mode", self._library.freenect_set_video_mode(self._device, video))
        for kind, take in (("video", on_colour), ("depth", on_depth)):
            callback = _without_device(take)
            self._kept.append(callback)  # C holds only its address
            getattr(self._library, f"freenect_set_{kind}_callback")(self._device, callback)
            started = getattr(self._library, f"freenect_start_{kind}")(self._device)
            self._tell(f"start the {kind} stream", started)

    def turn(self) -> None:
        """Wait up to a tenth of a second for USB, and hand over what came.

        Raises:
            Unusable: The device is gone.
        """
        wait = _Time(0, _TURN_US)
        self._tell("go on", self._library.freenect_process_events_timeout(self._context, byref(wait)))

    def close(self) -> None:
        """Stop both streams and let go of the device."""
        if not self._context:
            return
        for step in ("stop_video", "stop_depth", "close_device"):
            getattr(self._library, f"freenect_{step}")(self._device)
        self._library.freenect_shutdown(self._context)
        self._context = c_void_p()
        self._kept.clear()

    def _choose_depth(self) -> bool:
        """Registered depth where the library knows it; else raw."""
        registered = self._mode("depth", DEPTH_REGISTERED)
        chosen = registered or self._mode("depth", DEPTH_11_BIT)
        if chosen is None:
            raise Unusable("find 640 x 480 depth")
        self._tell("set the depth mode", self._library.freenect_set_depth_mode(self._device, chosen))
        return registered is not None

    def _mode(self, kind: str, wanted: int) -> _Mode | None:
        """The mode of 640 x 480 px with a format, among those that the library lists."""
        count = int(getattr(self._library, f"freenect_get_{kind}_mode_count")())
        for number in range(count):
            mode = getattr(self._library, f"freenect_get_{kind}_mode")(number)
            if mode.is_valid and mode.resolution == _MEDIUM and mode.format == wanted:
                return mode
        return None

    def _tell(self, step: str, result: int) -> None:
        if result < 0:
            raise Unusable(step)


def _without_device(take: ImageReceived) -> Any:
    """A C callback that hands over the image and its time."""

    def call(_device: int, image: int, ticks: int) -> None:
        take(image, ticks)

    return _Callback(call)


def count(library: Any) -> int:
    """How many Kinects are connected."""
    context = c_void_p()
    if library.freenect_init(byref(context), None) < 0:
        return 0
    try:
        return max(int(library.freenect_num_devices(context)), 0)
    finally:
        library.freenect_shutdown(context)
