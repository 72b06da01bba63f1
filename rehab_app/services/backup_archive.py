"""One backup file: a zip with the locked key and an encrypted tar, so that unzip, age and tar open it."""

from __future__ import annotations

import base64
import hashlib
import io
import os
import tarfile
import threading
import zipfile
from collections.abc import Callable, Generator, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import IO

import msgspec

from rehab_app.errors import Refused
from rehab_app.services import age
from rehab_app.services.backup_key import BackupKey, unlock

KEY, CONTENT, MANIFEST = "key.age", "clinic.tar.age", "manifest.json"
_README = """A backup of a clinic, made by rehab-app.
Restore it with:  rehab-app restore THIS_FILE --data NEW_FOLDER
Without rehab-app:  unzip it;  age -d key.age > key.txt;  age -d -i key.txt clinic.tar.age | tar -x
"""
_STEP = 1 << 20


@dataclass(frozen=True, slots=True)
class Manifest:
    """What a backup holds.

    Attributes:
        version: Version of this format.
        software: Version of the application that made it.
        utc_ns: When.
        sha256: Digest of every file by its name in the clinic folder.
    """

    version: int
    software: str
    utc_ns: int
    sha256: dict[str, str]


@dataclass(frozen=True, slots=True)
class Part:
    """One file to put into a backup.

    Attributes:
        name: Its name in the clinic folder, POSIX.
        path: Where it is now.
    """

    name: str
    path: Path


def write_archive(
    target: IO[bytes], parts: Iterator[Part], key: BackupKey, software: str, utc_ns: int
) -> Manifest:
    """Write a backup in one pass and constant memory. A part that is gone meanwhile is left out.

    Raises:
        OSError: The target cannot be written.
    """
    found: list[Manifest] = []
    with zipfile.ZipFile(target, "w", zipfile.ZIP_STORED, allowZip64=True) as archive:
        archive.writestr("README.txt", _README)
        archive.writestr(KEY, base64.b64decode(key.locked))
        with (
            archive.open(CONTENT, "w", force_zip64=True) as content,
            _fed(lambda pipe: found.append(_write_tar(pipe, parts, software, utc_ns))) as tar,
        ):
            age.encrypt(tar, content, key.recipient)
    return found[0]


def read_archive(source: Path, folder: Path, passphrase: str) -> Manifest:
    """Unpack a backup into an empty folder and check every digest.

    Raises:
        Refused: It is no backup, the passphrase is wrong, or it was cut or changed.
    """
    try:
        with zipfile.ZipFile(source) as archive:
            identity = unlock(archive.read(KEY), passphrase)
            with (
                archive.open(CONTENT) as content,
                _fed(lambda pipe: age.decrypt(content, pipe, identity)) as tar,
            ):
                return _unpack(tar, folder)
    except (zipfile.BadZipFile, KeyError, tarfile.TarError, age.Unreadable, EOFError) as error:
        raise _damaged(source) from error


def _write_tar(pipe: IO[bytes], parts: Iterator[Part], software: str, utc_ns: int) -> Manifest:
    digests: dict[str, str] = {}
    with tarfile.open(fileobj=pipe, mode="w|", format=tarfile.PAX_FORMAT) as tar:
        for part in parts:
            try:
                with part.path.open("rb") as file:
                    member = tarfile.TarInfo(part.name)
                    member.size, member.mode = os.fstat(file.fileno()).st_size, 0o600
                    reading = _Digesting(file)
                    tar.addfile(member, reading)
                    digests[part.name] = reading.digest.hexdigest()
            except FileNotFoundError:
                continue  # erased since the list was made
        manifest = Manifest(1, software, utc_ns, digests)
        text = msgspec.json.encode(manifest)
        last = tarfile.TarInfo(MANIFEST)
        last.size, last.mode = len(text), 0o600
        tar.addfile(last, io.BytesIO(text))
    return manifest


def _unpack(tar: IO[bytes], folder: Path) -> Manifest:
    digests: dict[str, str] = {}
    text = b""
    with tarfile.open(fileobj=tar, mode="r|") as archive:
        for member in archive:
            content = archive.extractfile(member)
            if content is None or not _inside(member.name):
                raise tarfile.TarError(f"{member.name!r} is no file of a clinic")
            if member.name == MANIFEST:
                text = content.read()
                continue
            digests[member.name] = _copy(content, folder / member.name)
    try:
        manifest = msgspec.json.decode(text, type=Manifest)
    except msgspec.DecodeError as error:
        raise tarfile.TarError("the manifest is damaged") from error
    if manifest.sha256 != digests:
        raise tarfile.TarError("a file is not what the manifest says")
    return manifest


def _copy(content: IO[bytes], target: Path) -> str:
    target.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
    digest = hashlib.sha256()
    with open(os.open(target, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "wb") as file:
        while block := content.read(_STEP):
            digest.update(block)
            file.write(block)
        file.flush()
        os.fsync(file.fileno())
    return digest.hexdigest()


def _inside(name: str) -> bool:
    pure = PurePosixPath(name)
    return not pure.is_absolute() and ".." not in pure.parts and bool(pure.parts)


class _Digesting(io.RawIOBase):
    """A file that is read, with the digest of what was read."""

    def __init__(self, file: IO[bytes]) -> None:
        self._file = file
        self.digest = hashlib.sha256()

    def readable(self) -> bool:
        return True

    def read(self, size: int = -1) -> bytes:
        block = self._file.read(size)
        self.digest.update(block)
        return block


@contextmanager
def _fed(feed: Callable[[IO[bytes]], object]) -> Generator[IO[bytes]]:
    """What another thread writes, as something to read; its failure is raised here.

    Raises:
        Exception: Whatever ``feed`` raised, unless the reader has left before.
    """
    reading, writing = os.pipe()
    failures: list[Exception] = []

    def run() -> None:
        try:
            with open(writing, "wb") as pipe:
                feed(pipe)
        except (OSError, tarfile.TarError, age.Unreadable, zipfile.BadZipFile, EOFError) as error:
            failures.append(error)

    thread = threading.Thread(target=run, name="backup", daemon=True)
    thread.start()
    try:
        with open(reading, "rb") as pipe:
            yield pipe
            while pipe.read(_STEP):  # what follows the end of a tar; a writer must not be left waiting
                pass
    except (tarfile.TarError, EOFError):
        thread.join()
        if failures:
            raise failures[0] from None
        raise
    finally:
        thread.join()
    if failures:
        raise failures[0]


def _damaged(source: Path) -> Refused:
    return Refused(
        f"backup {source.name}",
        "damaged, cut or no backup",
        "a whole file made by rehab-app backup",
        "use another copy of it; nothing was restored",
    )
