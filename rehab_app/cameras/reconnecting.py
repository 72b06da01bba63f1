"""A live camera that survives being unplugged: it waits, says so about twice a second, and goes on."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from types import TracebackType

from rehab_app.cameras.frame import Camera, Capture, Frame, Outage
from rehab_app.cameras.lease import CameraLease
from rehab_app.cameras.lost import CameraLost, closed
from rehab_app.geometry.pinhole import Intrinsics
from sessions.errors import Refused

OUTAGE_PERIOD_S = 0.5


@dataclass(frozen=True, slots=True)
class Clock:
    """The time by which captures are stamped and waited for; another one serves where time is simulated.

    Attributes:
        now_ns: Monotonic time, ns.
        sleep_s: Waits for a number of seconds.
    """

    now_ns: Callable[[], int] = time.monotonic_ns
    sleep_s: Callable[[float], None] = time.sleep


class Reconnecting:
    """A live camera, opened again as often as it is lost.

    While it is lost, an ``Outage`` comes twice a second. The first frame afterwards counts as ``dropped``
    what the camera would have captured meanwhile at its nominal rate.

    Args:
        make: Makes the source; its ``frames`` raise ``CameraLost`` when it gives nothing any more.
        lease: Exclusive right to the camera, kept while it is being waited for; None where none is needed.
        clock: Time.
    """

    def __init__(
        self, make: Callable[[], Camera], lease: CameraLease | None = None, clock: Clock | None = None
    ) -> None:
        self._make = make
        self._lease = lease
        self._clock = clock or Clock()
        self._source = make()
        self._connected = False
        self._open = False
        self._last_ns: int | None = None

    @property
    def name(self) -> str:
        """What a session file calls this source."""
        return self._source.name

    @property
    def intrinsics(self) -> Intrinsics:
        """Camera of the colour image."""
        return self._source.intrinsics

    @property
    def rate_hz(self) -> float:
        """Nominal frames per second."""
        return self._source.rate_hz

    @property
    def has_depth(self) -> bool:
        """Whether frames carry depth."""
        return self._source.has_depth

    def __enter__(self) -> Reconnecting:
        """Take the lease and open the camera.

        Raises:
            Refused: The camera is absent, busy or of no use.
        """
        if self._lease is not None:
            self._lease.take()
        try:
            self._source.__enter__()
        except BaseException:
            self._release()
            raise
        self._open = self._connected = True
        self._last_ns = None
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close the camera and give the lease back."""
        self._open = False
        try:
            self._disconnect()
        finally:
            self._release()

    def frames(self) -> Iterator[Capture]:
        """Frames while there are any, outages while there are none, until the camera is closed.

        Raises:
            Refused: The camera is not open, or it came back with another resolution.
        """
        if not self._open:
            raise closed()
        while self._open:
            reason = f"The camera {self.name} stopped: plug it in again."
            try:
                yield from self._following()
            except CameraLost as lost:
                reason = lost.reason
            if self._open:
                yield from self._waiting(reason)

    def _following(self) -> Iterator[Capture]:
        """What the source gives until it ends or is lost."""
        came_back = self._last_ns is not None
        for capture in self._source.frames():
            if isinstance(capture, Outage):
                yield capture
            elif self._last_ns is None or capture.t_capture_ns > self._last_ns:
                missed = self._missed(capture) if came_back else capture.dropped
                came_back, self._last_ns = False, capture.t_capture_ns
                yield replace(capture, dropped=missed)

    def _waiting(self, reason: str) -> Iterator[Outage]:
        """Outages until the camera is back or closed."""
        expected = self.intrinsics
        self._disconnect()
        while self._open:
            yield Outage(self._clock.now_ns(), reason)
            self._clock.sleep_s(OUTAGE_PERIOD_S)
            if self._open and self._reconnect(expected):
                return

    def _reconnect(self, expected: Intrinsics) -> bool:
        """Whether the camera could be opened again.

        Raises:
            Refused: It has another resolution now.
        """
        try:
            source = self._make()
            source.__enter__()
        except Refused:
            return False
        self._source, self._connected = source, True
        if source.intrinsics != expected:
            met = source.intrinsics
            raise Refused(
                f"camera {self.name} after it came back",
                f"{met.width_px} x {met.height_px} px with other intrinsics",
                f"the same as before ({expected.width_px} x {expected.height_px} px)",
                "start a new recording",
            )
        return True

    def _missed(self, frame: Frame) -> int:
        """Captures lost since the last frame, at the nominal rate."""
        gap_ns = frame.t_capture_ns - (self._last_ns or frame.t_capture_ns)
        return max(round(gap_ns * 1e-9 * self.rate_hz) - 1, 0)

    def _disconnect(self) -> None:
        if self._connected:
            self._connected = False
            self._source.__exit__(None, None, None)

    def _release(self) -> None:
        if self._lease is not None:
            self._lease.release()
