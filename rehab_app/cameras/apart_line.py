"""What a camera's own process and the one that uses it say to each other, frame by frame, over a socket.

A message is a line of JSON; behind that of a frame come the images as they lie in memory. Both ends are of
one machine and one version, and the clock of captures (monotonic) is the same for both.
"""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from multiprocessing.connection import Connection
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rehab_app.cameras.frame import Frame, Outage
from rehab_app.cameras.lost import CameraLost
from rehab_app.geometry.pinhole import Intrinsics
from sessions.errors import Refused


@dataclass(frozen=True, slots=True)
class Opened:
    """The camera is open.

    Attributes:
        intrinsics: Camera of the colour image.
        rate_hz: Nominal frames per second.
    """

    intrinsics: Intrinsics
    rate_hz: float


Said = Opened | Frame | Outage | Refused | CameraLost
"""All that a camera's process can say; after the last two it ends."""


class Line:
    """One end of the socket between a camera's process and the one that uses it.

    Args:
        connection: This end; it is closed with the line.
    """

    def __init__(self, connection: Connection) -> None:
        self._connection = connection
        self._lens: Intrinsics | None = None

    def tell(self, said: Said) -> None:
        """Send a message.

        Raises:
            OSError: Nobody listens any more.
        """
        kind, values = _written(said)
        self._connection.send_bytes(json.dumps([kind, values]).encode())
        if isinstance(said, Frame):
            for image in (said.colour_bgr, said.depth_m):
                if image is not None:
                    self._connection.send_bytes(np.ascontiguousarray(image).data.cast("B"))

    def hears_within(self, seconds: float) -> bool:
        """Whether a message, or the end of the other process, comes within a time, s.

        Raises:
            OSError: The line is closed.
        """
        return self._connection.poll(seconds)

    def hear(self) -> Said:
        """Wait for the next message.

        Raises:
            EOFError: The other process has ended.
            OSError: It ended in the middle of a message, or the line is closed.
        """
        kind, values = json.loads(self._connection.recv_bytes())
        if kind == "frame":
            return self._frame(**values)
        said = _read(kind, values)
        if isinstance(said, Opened):
            self._lens = said.intrinsics
        return said

    def close(self) -> None:
        """Hang up; the other process ends by itself."""
        self._connection.close()

    def _frame(self, t_ns: int, dropped: int, *, has_depth: bool) -> Frame:
        lens = self._lens
        if lens is None:
            raise EOFError("a frame before the camera was open")
        size = (lens.height_px, lens.width_px)
        colour, depth = np.empty((*size, 3), np.uint8), np.empty(size, np.float32) if has_depth else None
        self._fill(colour)
        if depth is not None:
            self._fill(depth)
        return Frame(t_ns, colour, depth, lens, dropped)

    def _fill(self, image: NDArray[Any]) -> None:
        """Fill an image with the next message."""
        self._connection.recv_bytes_into(image.data.cast("B"))


def _written(said: Said) -> tuple[str, dict[str, Any]]:
    match said:
        case Opened():
            return "opened", asdict(said)
        case Frame():
            has_depth = said.depth_m is not None
            return "frame", {"t_ns": said.t_capture_ns, "dropped": said.dropped, "has_depth": has_depth}
        case Outage():
            return "outage", asdict(said)
        case Refused():
            return "refused", {name: getattr(said, name) for name in ("thing", "value", "bound", "remedy")}
        case CameraLost():
            return "lost", {"reason": said.reason}


def _read(kind: str, values: dict[str, Any]) -> Said:
    if kind == "opened":
        return Opened(Intrinsics(**values["intrinsics"]), values["rate_hz"])
    whole: dict[str, type[Outage | Refused | CameraLost]] = {
        "outage": Outage,
        "refused": Refused,
        "lost": CameraLost,
    }
    return whole[kind](**values)
