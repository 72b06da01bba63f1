"""The word of a live camera that it gives nothing any more, and the sentences of sources that cannot open."""

from __future__ import annotations

from sessions.errors import Refused


class CameraLost(Exception):
    """An open camera stopped giving frames: unplugged, or its driver hangs.

    Only ``Reconnecting`` meets it; everybody else sees an ``Outage``.

    Args:
        reason: One sentence for a person.
    """

    def __init__(self, reason: str) -> None:
        super().__init__(reason)
        self.reason = reason


def closed() -> Refused:
    """Frames were asked of a camera that is not open."""
    return Refused("camera", "closed", "open", "open it before asking for frames")


def missing_extra(camera: str, extra: str) -> Refused:
    """The camera needs a package that is not installed."""
    return Refused(camera, "without its driver", "installed", f"run pip install 'rehab-app[{extra}]'")


def missing_library(camera: str, library: str, package: str) -> Refused:
    """The camera needs a library of the system that is not installed."""
    return Refused(
        camera, f"without {library}", "installed", f"install it (Debian: sudo apt-get install {package})"
    )


def absent(camera: str) -> Refused:
    """The camera is not there."""
    return Refused(
        camera, "not found", "connected", "plug it in, and see rehab-app camera list for what is there"
    )


def busy(camera: str) -> Refused:
    """The camera is there, but another program has it."""
    return Refused(
        camera, "in use by another program", "free", "end the other recording or program, then try again"
    )
