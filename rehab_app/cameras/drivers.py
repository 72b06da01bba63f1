"""What the USB libraries of depth cameras find, asked in a process of its own.

They start threads, take signals and at times bring their process down, also when nothing is plugged in: a
look at what there is must not end the server that shows a therapy. What is recorded from has a process of its
own too, see ``apart``.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass

from rehab_app.cameras import freenect_library, openni_library, realsense
from sessions.errors import Refused

_PATIENCE_S = 20.0
_COMMAND = (sys.executable, "-c", "from rehab_app.cameras import drivers; drivers.tell()")


@dataclass(frozen=True, slots=True)
class Found:
    """What one library says.

    Attributes:
        kind: ``realsense``, ``kinect`` or ``openni``.
        cameras: Name and label of each camera that is plugged in.
        remedy: Why it cannot tell, as one sentence of what to do; empty where it can.
    """

    kind: str
    cameras: tuple[tuple[str, str], ...] = ()
    remedy: str = ""


def look(kind: str) -> Found:
    """Ask one library in this process."""
    try:
        return Found(kind, _LIBRARIES[kind]())
    except Refused as refusal:
        return Found(kind, remedy=f"{refusal.remedy[:1].upper()}{refusal.remedy[1:]}.")


def look_apart(command: Sequence[str] = _COMMAND, patience_s: float = _PATIENCE_S) -> tuple[Found, ...]:
    """Ask every library in a process of its own; one that crashes or hangs there is found without cameras.

    Args:
        command: What writes a line of JSON for each library.
        patience_s: How long it may take.
    """
    told = {found.kind: found for found in _read(_run(command, patience_s))}
    return tuple(told.get(kind, _failed(kind)) for kind in _LIBRARIES)


def tell() -> None:
    """Ask each library and write a line about it; ends this process."""
    for kind in _LIBRARIES:
        sys.stdout.write(json.dumps(asdict(look(kind))) + "\n")
        sys.stdout.flush()
    os._exit(0)  # without the libraries' farewells, in which they crash


def _run(command: Sequence[str], patience_s: float) -> str:
    try:
        ran = subprocess.run(
            command,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            timeout=patience_s,
            check=False,
        )
    except subprocess.TimeoutExpired as late:
        return (late.stdout or b"").decode(errors="replace")
    return ran.stdout.decode(errors="replace")


def _read(text: str) -> list[Found]:
    """The lines of ours; libraries write to the same place."""
    found: list[Found] = []
    for line in text.splitlines():
        try:
            row = json.loads(line)
            cameras = tuple((str(name), str(label)) for name, label in row["cameras"])
            found.append(Found(row["kind"], cameras, row["remedy"]))
        except (ValueError, TypeError, KeyError):
            continue
    return found


def _failed(kind: str) -> Found:
    return Found(kind, remedy=f"Its driver fails: unplug the {kind} camera, plug it in again and look again.")


def _realsense() -> tuple[tuple[str, str], ...]:
    found = realsense.serials()
    return tuple((f"realsense:{serial}", model or "Intel RealSense") for serial, model in found)


def _kinects() -> tuple[tuple[str, str], ...]:
    count = freenect_library.count(freenect_library.load())
    return tuple((f"kinect:{index}", f"Kinect {index + 1} (first generation)") for index in range(count))


def _openni() -> tuple[tuple[str, str], ...]:
    return tuple(
        (f"openni:{index}", f"OpenNI camera at {uri}") for index, uri in enumerate(openni_library.uris())
    )


_LIBRARIES: dict[str, Callable[[], tuple[tuple[str, str], ...]]] = {
    "realsense": _realsense,
    "kinect": _kinects,
    "openni": _openni,
}
