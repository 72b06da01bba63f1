"""The exclusive lease of a camera across processes: a file lock that dies with its process."""

from __future__ import annotations

import os
import re
import tempfile
from pathlib import Path

from rehab_app.cameras.lost import busy
from sessions.filelock import FileLock, is_locked


class CameraLease:
    """The right to use one camera of this machine.

    Args:
        camera: Its name as ``rehab-app camera list`` prints it, such as ``webcam:0``.
        folder: Where lock files lie; by default one of this user's own.
    """

    def __init__(self, camera: str, folder: Path | None = None) -> None:
        self._camera = camera
        name = re.sub(r"[^A-Za-z0-9._-]", "_", camera)
        self._path = (_folder() if folder is None else folder) / f"{name}.lock"
        self._lock = FileLock(self._path)

    def take(self) -> None:
        """Take the camera.

        Raises:
            Refused: Another process, or another recording of this one, has it.
        """
        self._path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        if self._lock.held or not self._lock.take():
            raise busy(f"camera {self._camera}")

    def release(self) -> None:
        """Give the camera back; twice does no harm."""
        self._lock.release()

    @property
    def is_taken(self) -> bool:
        """Whether somebody has the camera now."""
        try:
            return is_locked(self._path)
        except FileNotFoundError:
            return False


def _folder() -> Path:
    """A folder that is this user's own and forgets with the machine's next start."""
    runtime = os.environ.get("XDG_RUNTIME_DIR")
    if runtime and os.access(runtime, os.W_OK):
        return Path(runtime) / "rehab-app"
    return Path(tempfile.gettempdir()) / f"rehab-app-{os.getuid()}"
