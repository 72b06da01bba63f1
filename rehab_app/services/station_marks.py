"""A file lock for each process that has patients in therapy: it dies with its process, and others know."""

from __future__ import annotations

import threading
import time
from contextlib import suppress
from pathlib import Path

from rehab_app.errors import Refused
from sessions.filelock import FileLock, is_locked

FOLDER = "stations"
_SUFFIX = ".lock"
_KEPT_S = 86_400.0


class StationMarks:
    """Which processes that worked in this clinic folder are still alive.

    A claim of one that died binds nobody: a server that was killed and started again goes on at once with the
    patient who sits there. Of processes on other machines nothing is known here, so their claims run out.

    Args:
        folder: The clinic's folder.
        holder: Name of this process.
    """

    def __init__(self, folder: Path, holder: str) -> None:
        self._folder = folder / FOLDER
        self._mine = self._folder / f"{holder}{_SUFFIX}"
        self._alive = FileLock(self._mine)
        self._turn = threading.Lock()

    def take(self) -> None:
        """Mark this process as alive; twice does no harm.

        Raises:
            Refused: The folder cannot be written.
        """
        with self._turn:
            if self._alive.held:
                return
            try:
                self._folder.mkdir(mode=0o700, parents=True, exist_ok=True)
                self._alive.take(wait=True)  # its name is this process's alone: nobody makes it wait
            except OSError as error:
                said = error.strerror or "an error"
                remedy = "make the clinic folder writable and free some space"
                raise Refused("station mark", said, "a file in the clinic folder", remedy) from error
            self._tidy()

    def gone(self) -> frozenset[str]:
        """Processes that left a mark in this folder and are not alive any more."""
        return frozenset(
            path.stem for path in self._folder.glob(f"*{_SUFFIX}") if path != self._mine and _is_free(path)
        )

    def _tidy(self) -> None:
        """Remove the marks of those that died long ago: their claims have run out."""
        for holder in self.gone():
            path = self._folder / f"{holder}{_SUFFIX}"
            with suppress(OSError):
                if time.time() - path.stat().st_mtime > _KEPT_S:
                    path.unlink()

    def release(self) -> None:
        """This process holds nothing any more."""
        with self._turn:
            if self._alive.held:
                self._mine.unlink(missing_ok=True)
                self._alive.release()


def _is_free(path: Path) -> bool:
    try:
        return not is_locked(path)
    except OSError:
        return False
