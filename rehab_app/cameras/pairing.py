"""Colour and depth that come one by one, paired by their capture times."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from numpy.typing import NDArray

_ALONE_MAX = 10


@dataclass(frozen=True, slots=True)
class Image:
    """One image of one of two streams.

    Attributes:
        number: Frame number of the device, from stream to stream not comparable.
        device_ns: Capture time by the device's clock, ns; both streams have the same clock.
        pixels: The image: colour (H, W, 3), or depth (H, W) in m.
    """

    number: int
    device_ns: int
    pixels: NDArray[Any]


class Pairing:
    """Holds the newest image of each stream until both are of one capture.

    Streams whose clocks do not agree (no pair after some images) are paired by arrival instead.

    Args:
        apart_ns: Largest difference in time of two images of one capture.
    """

    def __init__(self, apart_ns: int) -> None:
        self._apart_ns = apart_ns
        self._held: dict[str, Image] = {}
        self._alone = 0

    def add(self, kind: str, image: Image) -> tuple[Image, Image] | None:
        """The colour and depth image of one capture, once both are there.

        Args:
            kind: ``colour`` or ``depth``.
            image: The newest image of that stream.
        """
        self._held[kind] = image
        colour, depth = self._held.get("colour"), self._held.get("depth")
        if colour is None or depth is None:
            return None
        if abs(colour.device_ns - depth.device_ns) > self._apart_ns and self._alone < _ALONE_MAX:
            self._alone += 1
            return None
        self._held.clear()
        if self._alone < _ALONE_MAX:
            self._alone = 0
        return colour, depth
