"""The process that one live camera is read in: ``... -m rehab_app.cameras.apart_reader SOCKET SPEC LENS``."""

from __future__ import annotations

import json
import os
import sys
import threading
import time
from multiprocessing.connection import Connection

from rehab_app.cameras.apart_line import Line, Opened
from rehab_app.cameras.frame import Camera
from rehab_app.cameras.lost import CameraLost
from rehab_app.geometry.pinhole import Intrinsics
from sessions.errors import Refused

_FAREWELL_S = 2.0
"""How long a driver may take to close its camera once nobody listens any more."""


def read(camera: Camera, connection: Connection) -> None:
    """Open a camera and tell what it gives until nobody listens or it is lost; this ends the process.

    Args:
        camera: Not yet open.
        connection: To the process that uses it.
    """
    line = Line(connection)
    threading.Thread(target=_end_after, args=(connection,), daemon=True).start()
    try:
        with camera:
            line.tell(Opened(camera.intrinsics, camera.rate_hz))
            for capture in camera.frames():
                line.tell(capture)
        line.tell(CameraLost(f"The camera {camera.name} stopped: plug it in again."))
    except (Refused, CameraLost) as reason:
        _last_word(line, reason)
    except OSError:
        pass  # nobody listens any more
    os._exit(0)  # without the farewells of libraries, in which they crash or hang


def _last_word(line: Line, reason: Refused | CameraLost) -> None:
    try:
        line.tell(reason)
    except OSError:
        return


def _end_after(connection: Connection) -> None:
    """End this process soon after the one that uses it has hung up, even if the driver never returns."""
    try:
        connection.recv_bytes()
    except (EOFError, OSError):
        time.sleep(_FAREWELL_S)
        os._exit(1)


def main(descriptor: str, spec: str, lens: str) -> None:
    """Read the live camera of a name.

    Args:
        descriptor: Number of the inherited socket.
        spec: Name of the camera.
        lens: Its intrinsics as JSON, ``null`` if it has none.
    """
    from rehab_app.cameras.opening import live_source

    known = json.loads(lens)
    read(live_source(spec, Intrinsics(**known) if known else None), Connection(int(descriptor)))


if __name__ == "__main__":
    main(*sys.argv[1:])
