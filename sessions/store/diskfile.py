"""The file that a session is written to: hashed as it grows, and moved to its final name when whole."""

from __future__ import annotations

import contextlib
import hashlib
import os
import threading
from pathlib import Path
from typing import BinaryIO

from sessions.errors import Refused
from sessions.filelock import is_locked, lock_open

SUFFIX = ".mcap"
PARTIAL_SUFFIX = ".partial.mcap"


class HashedFile:
    """A new file that only grows; its SHA-256 is known without reading it again.

    Args:
        path: Where to create it; nothing may exist there.

    Raises:
        OSError: It cannot be created.
    """

    def __init__(self, path: Path) -> None:
        self._file: BinaryIO = path.open("xb")
        with contextlib.suppress(OSError):  # a file system without locks can only not tell who writes
            lock_open(self._file)
        self._hash = hashlib.sha256()
        self._size = 0
        self._settling = threading.Lock()
        sync_folder(path.parent)  # a power cut must not lose the name of what is settled

    def write(self, data: bytes) -> int:
        """Append bytes; they reach the system with ``flush``."""
        self._hash.update(data)
        self._size += len(data)
        return self._file.write(data)

    def tell(self) -> int:
        """How many bytes were written."""
        return self._size

    def flush(self) -> None:
        """Hand everything to the operating system, which keeps it even if this process is killed."""
        self._file.flush()

    def settle(self) -> None:
        """Wait until the disk has what the system was handed; any thread, beside one that writes."""
        with self._settling:
            if not self._file.closed:
                os.fdatasync(self._file.fileno())

    def sync(self) -> None:
        """Flush, and wait until the disk has it."""
        self._file.flush()
        os.fsync(self._file.fileno())

    def close(self) -> None:
        """Close the file; safe to call twice."""
        with self._settling:
            self._file.close()

    def sha256(self) -> str:
        """Digest of everything written so far, in hexadecimal."""
        return self._hash.hexdigest()


def partial_path(path: Path) -> Path:
    """Where a session lies until it is sealed: ``walk.mcap`` grows as ``walk.partial.mcap``."""
    return path.with_name(path.name.removesuffix(SUFFIX) + PARTIAL_SUFFIX)


def digest_path(path: Path) -> Path:
    """Where the SHA-256 of a sealed file lies, in the form that ``sha256sum -c`` reads."""
    return path.with_name(path.name + ".sha256")


def is_being_written(path: Path) -> bool:
    """Whether a living process holds this partial session open for writing; its lock dies with it."""
    try:
        return is_locked(path)
    except OSError:
        return False


def check_target(path: Path) -> None:
    """Refuse a path that a session cannot be written to.

    Raises:
        Refused: It does not end in .mcap, its folder does not exist, or a file is there already.
    """
    if path.suffix != SUFFIX or path.name.endswith(PARTIAL_SUFFIX) or path.name == SUFFIX:
        raise Refused("session file", repr(path.name), "a name that ends in .mcap", "give it that ending")
    if not path.parent.is_dir():
        raise Refused("folder", repr(str(path.parent)), "an existing folder", "create it first")
    if path.exists():
        raise Refused("session file", f"{path.name!r}, which exists", "a new name", "choose another name")


def publish(partial: Path, path: Path, sha256: str) -> None:
    """Write the digest beside the final name, then move the file there in one step.

    Raises:
        OSError: The disk refuses.
        Refused: A file has meanwhile taken the final name.
    """
    check_target(path)
    digest = digest_path(path)
    with digest.with_name(digest.name + ".new").open("w", encoding="utf-8") as file:
        file.write(f"{sha256}  {path.name}\n")
        file.flush()
        os.fsync(file.fileno())
    Path(file.name).replace(digest)
    partial.rename(path)
    sync_folder(path.parent)


def sync_folder(folder: Path) -> None:
    """Wait until the disk has the names in a folder.

    Raises:
        OSError: The folder cannot be read.
    """
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
