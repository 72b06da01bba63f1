"""The exclusive lease of a clinic folder's one server: a file lock that dies with its process."""

from __future__ import annotations

import os
from pathlib import Path

from rehab_app.errors import Refused
from sessions.filelock import FileLock


class ServerLease:
    """Holds the lock of a clinic folder until it is released or the process ends.

    Args:
        path: Lock file; it names the process that holds it.

    Raises:
        Refused: Another process holds the lock.
    """

    def __init__(self, path: Path) -> None:
        self._lock = FileLock(path)
        if not self._lock.take():
            holder = path.read_text("ascii", "replace")[:20].strip() or "unknown"
            raise Refused(
                f"clinic folder {path.parent}",
                f"served by process {holder} already",
                "free of another server",
                "use that server, end it, or name another folder with --data",
            )
        self._lock.write(f"{os.getpid()}\n")

    def release(self) -> None:
        """Give the lock back; twice does no harm."""
        self._lock.release()
