"""A lock on a file that dies with the process that holds it: by it processes know of each other."""

from __future__ import annotations

import fcntl
import os
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path
from typing import IO

_PRIVATE = 0o600


class FileLock:
    """An exclusive lock (``flock``) on a file of its own, for as long as somebody wants or the process lives.

    The file stays when the lock goes. A child process does not inherit it.

    Args:
        path: The file; made when the lock is taken, its folder must exist.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._descriptor = -1

    @property
    def held(self) -> bool:
        """Whether this object holds the lock."""
        return self._descriptor >= 0

    def take(self, *, wait: bool = False) -> bool:
        """Take the lock.

        Args:
            wait: Whether to wait until it is free; for files that only somebody who looks holds for a moment.

        Returns:
            Whether it is held now; False where another process, or another object of this one, holds it.

        Raises:
            OSError: The file cannot be opened, or the file system has no locks.
        """
        if self.held:
            return True
        descriptor = os.open(self._path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, _PRIVATE)
        try:
            taken = lock_open(descriptor, wait=wait)
        except BaseException:
            os.close(descriptor)
            raise
        if taken:
            self._descriptor = descriptor
        else:
            os.close(descriptor)
        return taken

    def release(self) -> None:
        """Give the lock back; twice does no harm."""
        if self.held:
            os.close(self._descriptor)
            self._descriptor = -1

    def write(self, text: str) -> None:
        """Write into the file who holds the lock; only while it is held."""
        os.ftruncate(self._descriptor, 0)
        os.pwrite(self._descriptor, text.encode(), 0)


@contextmanager
def alone(path: Path) -> Generator[bool]:
    """Whether this process holds the lock of a file, until the end of the block.

    Raises:
        OSError: As ``FileLock.take``.
    """
    lock = FileLock(path)
    try:
        yield lock.take()
    finally:
        lock.release()


def lock_open(file: int | IO[bytes], *, wait: bool = False) -> bool:
    """Lock an open file until it is closed; False where another holds it.

    Raises:
        OSError: The file system has no locks.
    """
    try:
        fcntl.flock(file, fcntl.LOCK_EX if wait else fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    return True


def is_locked(path: Path) -> bool:
    """Whether anybody, this process too, holds the lock of a file; it is not made.

    Raises:
        OSError: The file is not there or cannot be read, or the file system has no locks.
    """
    with path.open("rb") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
        except BlockingIOError:
            return True
    return False
