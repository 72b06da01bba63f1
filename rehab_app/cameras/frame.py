"""What every camera gives: colour and depth of one instant in one object; and the port they share."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from types import TracebackType
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from rehab_app.geometry.pinhole import Intrinsics

Colour = NDArray[np.uint8]
Depth = NDArray[np.float32]


@dataclass(frozen=True, slots=True)
class Frame:
    """Colour and depth, registered to each other, of one capture.

    Attributes:
        t_capture_ns: Capture time, monotonic, ns.
        colour_bgr: Colour image, shape (H, W, 3).
        depth_m: Depth along the optical axis, shape (H, W), m; 0 where the sensor saw none. None of a
            camera that has no depth.
        intrinsics: Camera of both images.
        dropped: Captures lost between the previous frame and this one.
    """

    t_capture_ns: int
    colour_bgr: Colour
    depth_m: Depth | None
    intrinsics: Intrinsics
    dropped: int = 0


@dataclass(frozen=True, slots=True)
class Outage:
    """A while in which an open camera gave no frame; it is still being waited for.

    Attributes:
        t_ns: When this is said, monotonic, ns.
        reason: One sentence for a person, such as that the camera was unplugged and what to do.
    """

    t_ns: int
    reason: str


Capture = Frame | Outage
"""What an open camera hands over: a frame, or the word that there is none."""


class Camera(Protocol):
    """An RGB-D camera. Entering the context takes it exclusively, leaving gives it back."""

    @property
    def name(self) -> str:
        """What a session file calls this source, such as ``virtual-camera``."""
        ...

    @property
    def intrinsics(self) -> Intrinsics:
        """Camera of the colour image, to which depth is registered."""
        ...

    @property
    def rate_hz(self) -> float:
        """Nominal frames per second."""
        ...

    def __enter__(self) -> Camera:
        """Open the camera; its clock starts."""
        ...

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close the camera."""
        ...

    @property
    def has_depth(self) -> bool:
        """Whether frames carry depth; without it only the direction of what is seen is known."""
        ...

    def frames(self) -> Iterator[Capture]:
        """Captures in order, strictly rising in time.

        A live camera goes on while it is open: when it is unplugged it hands over an ``Outage`` about twice a
        second until it is back, and counts what was lost as ``dropped`` of the next frame. A recorded one
        ends with its recording.

        Raises:
            Refused: The camera is not open, or what it gives can never be used (one sentence says why).
        """
        ...
