"""What still has to be done in the object store: one small file for each act, which outlives the process."""

from __future__ import annotations

import os
from collections.abc import Generator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, TypeAlias

from rehab_app.errors import Refused

Act: TypeAlias = Literal["put", "delete"]
Kind: TypeAlias = Literal["sessions", "takes"]
_ACTS: tuple[Act, ...] = ("put", "delete")
_KINDS: tuple[Kind, ...] = ("sessions", "takes")
_SHA256_LETTERS = 64
_PRIVATE = 0o700
_STORED = "stored.txt"
_TROUBLE = "trouble.txt"
FOLDER = "uploads"


@dataclass(frozen=True, slots=True)
class Errand:
    """One act that waits.

    Attributes:
        act: Send a file, or delete an object.
        kind: Room of the clinic folder that the file lies in.
        sha256: Digest of the file.
        path: Path relative to the clinic folder; "" where an object is deleted.
    """

    act: Act
    kind: Kind
    sha256: str
    path: str = ""

    @property
    def name(self) -> str:
        """File name of the errand, which says all but the path."""
        return f"{self.act}-{self.kind}-{self.sha256}"


class ErrandQueue:
    """Errands in the folder ``uploads`` of a clinic; any process may add, one at a time works them off.

    Args:
        root: The clinic folder.

    Attributes:
        folder: Where they lie; made with the first.
    """

    def __init__(self, root: Path) -> None:
        self.folder = root / FOLDER

    def add(self, errand: Errand) -> None:
        """Keep an errand; it is on the disk when this returns, and twice is once.

        Raises:
            Refused: The disk refuses; nothing is left of the errand.
        """
        with _refusing():
            self.folder.mkdir(mode=_PRIVATE, exist_ok=True)
            _keep(self.folder / errand.name, errand.path)
            _settle(self.folder)

    def holds(self, errand: Errand) -> bool:
        """Whether an errand still waits."""
        return (self.folder / errand.name).exists()

    def remove(self, errand: Errand) -> None:
        """An errand is done; removing it twice does no harm."""
        (self.folder / errand.name).unlink(missing_ok=True)

    def waiting(self) -> tuple[Errand, ...]:
        """All errands, deletions first."""
        if not self.folder.is_dir():
            return ()
        found = (self._read(name) for name in sorted(os.listdir(self.folder)))
        return tuple(errand for errand in found if errand is not None)

    def lock_path(self) -> Path:
        """File whose lock the one holds that works the errands off."""
        self.folder.mkdir(mode=_PRIVATE, exist_ok=True)
        return self.folder / ".lock"

    def trouble(self) -> str:
        """Why the last pass did not finish, "" where it did."""
        try:
            return (self.folder / _TROUBLE).read_text(encoding="utf-8")
        except FileNotFoundError:
            return ""

    def keep_trouble(self, sentence: str) -> None:
        """Keep why a pass did not finish; "" once one did.

        Raises:
            Refused: The disk refuses.
        """
        path = self.folder / _TROUBLE
        with _refusing():
            if sentence:
                _keep(path, sentence)
            else:
                path.unlink(missing_ok=True)

    def _read(self, name: str) -> Errand | None:
        act, _, rest = name.partition("-")
        kind, _, sha256 = rest.partition("-")
        if act not in _ACTS or kind not in _KINDS or len(sha256) != _SHA256_LETTERS:
            return None
        try:
            path = (self.folder / name).read_text(encoding="utf-8")
        except FileNotFoundError:
            return None
        return Errand(act, kind, sha256, path)


class StoredMarks:
    """Which files were proven to lie in the object store; a line each, and a lost line costs one more proof.

    Args:
        root: The clinic folder.
    """

    def __init__(self, root: Path) -> None:
        self._file = root / FOLDER / _STORED
        self._read_bytes = 0
        self._marks: set[str] = set()

    def __len__(self) -> int:
        return len(self._current())

    def has(self, kind: str, sha256: str) -> bool:
        """Whether a file was proven to lie there."""
        return f"{kind}/{sha256}" in self._current()

    def note(self, kind: str, sha256: str) -> None:
        """A file lies there, proven.

        Raises:
            Refused: The disk refuses.
        """
        self._append(f"+{kind}/{sha256}")

    def forget(self, kind: str, sha256: str) -> None:
        """A file lies there no more.

        Raises:
            Refused: The disk refuses.
        """
        self._append(f"-{kind}/{sha256}")

    def _append(self, line: str) -> None:
        with _refusing():
            self._file.parent.mkdir(mode=_PRIVATE, exist_ok=True)
            self._write(line)

    def _write(self, line: str) -> None:
        with self._file.open("a", encoding="utf-8") as file:
            file.write(f"\n{line}\n")  # a line torn by a power cut must not swallow this one
            file.flush()
            os.fsync(file.fileno())

    def _current(self) -> set[str]:
        """The marks, with what other processes have added since."""
        size = self._file.stat().st_size if self._file.exists() else 0
        if size < self._read_bytes:
            self._read_bytes, self._marks = 0, set()
        if size > self._read_bytes:
            with self._file.open("rb") as file:
                file.seek(self._read_bytes)
                content = file.read()
            whole = content[: content.rfind(b"\n") + 1]
            self._read_bytes += len(whole)
            for line in whole.decode("utf-8", "replace").split("\n"):
                if line.startswith("+"):
                    self._marks.add(line[1:])
                elif line.startswith("-"):
                    self._marks.discard(line[1:])
        return self._marks


def withdraw(root: Path, named: str) -> None:
    """A patient was erased: whatever an object store holds of a file will be deleted.

    A clinic that never used an object store has no folder of errands, and none is made.

    Args:
        root: The clinic folder.
        named: Room and digest of the file, with a slash between.

    Raises:
        Refused: The disk refuses.
    """
    queue = ErrandQueue(root)
    kind, _, sha256 = named.partition("/")
    if not queue.folder.is_dir() or kind not in _KINDS:
        return
    queue.add(Errand("delete", kind, sha256))
    queue.remove(Errand("put", kind, sha256))


@contextmanager
def _refusing() -> Generator[None]:
    """Say in one sentence that the disk refuses."""
    try:
        yield
    except OSError as error:
        why = (error.strerror or str(error)).lower()
        remedy = "make room there; what waits is done at the next pass"
        raise Refused(
            "queue of the object store", f"not writable ({why})", "on a disk with space", remedy
        ) from error


def _keep(path: Path, text: str) -> None:
    """Write a small file whole or not at all."""
    working = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        with working.open("w", encoding="utf-8") as file:
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
        working.replace(path)
    finally:
        working.unlink(missing_ok=True)


def _settle(folder: Path) -> None:
    """Wait until the disk has the names in a folder."""
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
