"""The exclusive lease of a clinic folder's one server: a file lock that dies with its process."""

from __future__ import annotations

import fcntl
import os
from pathlib import Path

from rehab_app.errors import Refused


class ServerLease:
    """Holds the lock of a clinic folder until it is released or the process ends.

    Args:
        path: Lock file; it names the process that holds it.

    Raises:
        Refused: Another process holds the lock.
    """

    def __init__(self, path: Path) -> None:
        self._descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o600)
        try:
            fcntl.flock(self._descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            holder = os.read(self._descriptor, 20).decode("ascii", "replace").strip() or "unknown"
            os.close(self._descriptor)
            raise Refused(
                f"clinic folder {path.parent}",
                f"served by process {holder} already",
                "free of another server",
                "use that server, end it, or name another folder with --data",
            ) from None
        os.ftruncate(self._descriptor, 0)
        os.write(self._descriptor, f"{os.getpid()}\n".encode("ascii"))

    def release(self) -> None:
        """Give the lock back; twice does no harm."""
        if self._descriptor >= 0:
            os.close(self._descriptor)
            self._descriptor = -1
