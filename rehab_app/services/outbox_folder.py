"""What waits for the catalogue of a server: a small file for each row, in order."""

from __future__ import annotations

import os
from collections.abc import Generator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec

from sessions.filelock import alone

FOLDER = "outbox"
_ASIDE = "aside"
_PRIVATE = 0o700
_SUFFIX = ".json"
_WHY = ".why"
_WORKING = ".part"


class Waiting(msgspec.Struct, frozen=True):
    """One row, or the rows of one act, that wait.

    Attributes:
        id: Number of the delivery, drawn by chance; the catalogue knows by it what has arrived.
        kind: What it is, such as "session".
        utc_ns: When it was made.
        content: The fields of its frozen value.
    """

    id: str
    kind: str
    utc_ns: int
    content: dict[str, Any]


@dataclass(frozen=True, slots=True)
class Letter:
    """A file that waits.

    Attributes:
        path: The file.
        row: What it holds, None where it is damaged.
    """

    path: Path
    row: Waiting | None


@dataclass(frozen=True, slots=True)
class Aside:
    """A file that was set aside.

    Attributes:
        name: Its name.
        why: One sentence.
    """

    name: str
    why: str


class OutboxFolder:
    """Files in the folder ``outbox`` of a clinic; any process may add, one at a time delivers.

    Args:
        root: The clinic folder.

    Attributes:
        folder: Where they lie; made with the first.
    """

    def __init__(self, root: Path) -> None:
        self.folder = root / FOLDER

    def add(self, row: Waiting) -> Path:
        """Keep a row behind all others; it is on the disk when this returns.

        Raises:
            OSError: The disk refuses.
        """
        self.folder.mkdir(mode=_PRIVATE, exist_ok=True)
        working = self.folder / f".{row.id}{_WORKING}"
        try:
            _write(working, msgspec.json.encode(row))
            target = self._linked(working)
        finally:
            working.unlink(missing_ok=True)
        _settle(self.folder)
        return target

    def names(self) -> tuple[str, ...]:
        """Names of the files that wait, in order."""
        try:
            found = os.listdir(self.folder)
        except FileNotFoundError:
            return ()
        return tuple(sorted(name for name in found if name.endswith(_SUFFIX) and not name.startswith(".")))

    def waiting(self) -> Generator[Letter]:
        """The files that wait, in order, also those that are added meanwhile."""
        seen = ""
        while True:
            name = next((one for one in self.names() if one > seen), "")
            if not name:
                return
            seen = name
            path = self.folder / name
            yield Letter(path, _read(path))

    def remove(self, path: Path) -> None:
        """A row arrived; removing its file twice does no harm."""
        path.unlink(missing_ok=True)

    def set_aside(self, letter: Letter, why: str, content: Waiting | None) -> None:
        """A row cannot arrive: it is kept beside, with the reason, and the rest goes on.

        Args:
            letter: The file.
            why: One sentence.
            content: What of it is kept; None to keep the file as it is.

        Raises:
            OSError: The disk refuses.
        """
        aside = self.folder / _ASIDE
        aside.mkdir(mode=_PRIVATE, exist_ok=True)
        _write(aside / f"{letter.path.name}{_WHY}", why.encode())
        if content is not None:
            working = aside / f".{letter.path.name}{_WORKING}"
            _write(working, msgspec.json.encode(content))
            working.replace(letter.path)
        letter.path.replace(aside / letter.path.name)
        _settle(aside)

    def aside(self) -> tuple[Aside, ...]:
        """What was set aside, oldest first."""
        found = sorted((self.folder / _ASIDE).glob(f"*{_SUFFIX}"))
        return tuple(Aside(path.name, _text(path.with_name(path.name + _WHY))) for path in found)

    def recordings(self) -> frozenset[str]:
        """Paths, relative to the clinic folder, of recordings that wait or were set aside."""
        beside = (_read(path) for path in (self.folder / _ASIDE).glob(f"*{_SUFFIX}"))
        rows = (*(letter.row for letter in self.waiting()), *beside)
        return frozenset(
            str(row.content["path"]) for row in rows if row is not None and "path" in row.content
        )

    @contextmanager
    def delivering(self) -> Generator[bool]:
        """Whether this process is the one that delivers now."""
        self.folder.mkdir(mode=_PRIVATE, exist_ok=True)
        with alone(self.folder / ".lock") as free:
            yield free

    def _linked(self, working: Path) -> Path:
        """Give a file the next number, which no other process can have given at the same moment."""
        names = self.names()
        number = int(names[-1].removesuffix(_SUFFIX)) if names else 0
        while True:
            number += 1
            target = self.folder / f"{number:012d}{_SUFFIX}"
            try:
                os.link(working, target)
            except FileExistsError:
                continue
            return target


def _read(path: Path) -> Waiting | None:
    try:
        return msgspec.json.decode(path.read_bytes(), type=Waiting)
    except (OSError, msgspec.MsgspecError, UnicodeDecodeError):
        return None


def _text(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8", errors="replace")
    except OSError:
        return "nobody knows why"


def _write(path: Path, content: bytes) -> None:
    """Write a file that only its owner may read, and wait until the disk has it."""
    descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600)
    with os.fdopen(descriptor, "wb") as file:
        file.write(content)
        file.flush()
        os.fsync(file.fileno())


def _settle(folder: Path) -> None:
    """Wait until the disk has the names in a folder."""
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
