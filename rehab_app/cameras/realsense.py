"""Intel RealSense cameras: colour, and depth aligned to it. Needs the extra ``realsense``."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from importlib import import_module
from types import TracebackType
from typing import Any

from rehab_app.cameras.device_clock import DeviceClock
from rehab_app.cameras.frame import Frame
from rehab_app.cameras.lost import CameraLost, absent, busy, closed, missing_extra
from rehab_app.cameras.realsense_lens import Straightening
from rehab_app.cameras.realsense_streams import choose
from rehab_app.geometry.pinhole import Intrinsics
from sessions.errors import Refused

_SIZE_PX = (640, 480)
_RATE_HZ = 30
_FIRST_WAIT_MS = 5000
_WAIT_MS = 1000


def driver() -> Any:
    """The module ``pyrealsense2``.

    Raises:
        Refused: The extra is not installed.
    """
    try:
        return import_module("pyrealsense2")
    except ImportError:
        raise missing_extra("RealSense camera", "realsense") from None


def serials() -> tuple[tuple[str, str], ...]:
    """Serial number and model of every RealSense camera that is connected.

    Raises:
        Refused: The extra is not installed.
    """
    rs = driver()
    return tuple((_told(rs, found, "serial_number"), _told(rs, found, "name")) for found in _devices(rs))


class RealSenseCamera:
    """One RealSense camera at 640 x 480 and 30 Hz, or what is asked for.

    Lens distortion of the colour image, where the camera states one, is removed from colour and depth.

    Args:
        serial: Serial number; None takes the first.
        size_px: Width and height of the colour image.
        rate_hz: Frames per second of both images.
        find: Finds the device, given the driver and the serial number; None if there is none. By default
            among those connected.
    """

    name = "realsense"
    has_depth = True

    def __init__(
        self,
        serial: str | None = None,
        *,
        size_px: tuple[int, int] = _SIZE_PX,
        rate_hz: int = _RATE_HZ,
        find: Callable[[Any, str | None], Any] | None = None,
    ) -> None:
        self._serial = serial
        self._size_px = size_px
        self._rate_hz = rate_hz
        self._find = find or _connected
        self._title = f"camera realsense:{serial}" if serial else "camera realsense"
        self._sensors: list[Any] = []
        self._frames: Any = None
        self._lens: Straightening | None = None

    @property
    def intrinsics(self) -> Intrinsics:
        """Camera of the colour image; known once the camera is open.

        Raises:
            Refused: The camera was never open.
        """
        if self._lens is None:
            raise closed()
        return self._lens.intrinsics

    @property
    def rate_hz(self) -> float:
        """Frames per second."""
        return float(self._rate_hz)

    def __enter__(self) -> RealSenseCamera:
        """Start both streams.

        Raises:
            Refused: The extra is missing, or the camera is absent, busy or without this resolution.
        """
        rs = driver()
        device = self._find(rs, self._serial)
        if device is None:
            raise absent(self._title)
        chosen = choose(rs, device, self._size_px, self._rate_hz, self._title)
        self._lens = Straightening(rs, chosen.colour)
        self._frames = rs.syncer(4)
        try:
            for sensor, profiles in chosen.sensors:
                sensor.open(profiles)
                self._sensors.append(sensor)
                sensor.start(self._frames)
        except RuntimeError as error:
            self.__exit__(None, None, None)
            raise _unopened(self._title, error) from error
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Stop both streams."""
        sensors, self._sensors, self._frames = self._sensors, [], None
        for sensor in sensors:
            for leave in (sensor.stop, sensor.close):
                try:
                    leave()
                except RuntimeError:
                    continue  # unplugged, or never started: there is nothing left to stop

    def frames(self) -> Iterator[Frame]:
        """Frames as they come; ``dropped`` by the camera's own frame numbers.

        Raises:
            Refused: The camera is not open.
            CameraLost: It gives nothing any more.
        """
        rs, waiting = driver(), self._frames
        if waiting is None or self._lens is None:
            raise closed()
        align: Any = rs.align(rs.stream.color)
        clock = DeviceClock()
        last: int | None = None
        wait_ms = _FIRST_WAIT_MS
        while self._frames is waiting:
            both = self._next(align, waiting, wait_ms)
            if both is None:
                continue
            colour, depth = both
            number = int(colour.get_frame_number())
            if last is not None and number <= last:
                continue
            wait_ms = _WAIT_MS
            t_ns = clock.monotonic_ns(round(1e6 * colour.get_timestamp()), time.monotonic_ns())
            dropped = 0 if last is None else number - last - 1
            yield self._lens.frame(t_ns, colour, depth, dropped)
            last = number

    def _next(self, align: Any, waiting: Any, wait_ms: int) -> tuple[Any, Any] | None:
        """The next colour frame with the depth aligned to it; None where one of them is missing."""
        try:
            came, both = waiting.try_wait_for_frames(wait_ms)
        except RuntimeError:
            came, both = False, None
        if not came or both is None:
            raise CameraLost("The RealSense camera stopped sending: plug it in again.")
        if both.size() < 2:
            return None
        try:
            aligned = align.process(both)
        except RuntimeError:
            return None
        colour, depth = aligned.get_color_frame(), aligned.get_depth_frame()
        return (colour, depth) if colour and depth else None


def _devices(rs: Any) -> list[Any]:
    return list(rs.context().query_devices())


def _connected(rs: Any, serial: str | None) -> Any:
    for found in _devices(rs):
        if serial in (None, _told(rs, found, "serial_number")):
            return found
    return None


def _told(rs: Any, device: Any, what: str) -> str:
    kind = getattr(rs.camera_info, what)
    return str(device.get_info(kind)) if device.supports(kind) else ""


def _unopened(title: str, error: RuntimeError) -> Refused:
    words = str(error).splitlines()[0] if str(error) else "no reason given"
    if "busy" in words.lower() or "power state" in words.lower():
        return busy(title)
    return Refused(title, f"not usable ({words})", "ready", "plug it in again, into a USB 3 socket")
