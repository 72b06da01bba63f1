"""Backups of a clinic: one encrypted file, consistent, made while the clinic works."""

from __future__ import annotations

import os
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import IO, cast

import msgspec

from rehab_app.access import Account, require
from rehab_app.config import ClinicFolder
from rehab_app.errors import Refused
from rehab_app.services.audit import Audit
from rehab_app.services.backup_archive import Part, write_archive
from rehab_app.services.backup_key import BackupKey, key_from_json, key_to_json, new_key
from rehab_app.services.erased_ledger import LEDGER, add_to_ledger, ledger
from sessions.catalogue import Catalogue, Setting
from sessions.catalogue.catalogue import FILE

KEY, LAST = "backup key", "last backup"
SUFFIX = ".rehab-backup"


@dataclass(frozen=True, slots=True)
class MadeBackup:
    """A backup that was made.

    Attributes:
        utc_ns: When.
        files: How many files it holds.
        bytes: Its size.
        by: Who made it.
    """

    utc_ns: int
    files: int
    bytes: int
    by: str


class Backups:
    """Makes backups.

    Args:
        folder: The clinic folder.
        catalogue: Its catalogue.
        audit: Where backups are noted.
        software: Version of the application.
        clock_ns: UTC in ns.
    """

    def __init__(
        self,
        folder: ClinicFolder,
        catalogue: Catalogue,
        audit: Audit,
        software: str,
        clock_ns: Callable[[], int] = time.time_ns,
    ) -> None:
        self._folder = folder
        self._catalogue = catalogue
        self._audit = audit
        self._software = software
        self._clock_ns = clock_ns

    def key(self) -> BackupKey | None:
        """The clinic's key, None before somebody set a passphrase."""
        kept = self._catalogue.setting(KEY)
        return None if kept is None else key_from_json(kept.content)

    def set_passphrase(self, actor: Account, passphrase: str) -> BackupKey:
        """Draw a new key and lock it; backups made before keep the passphrase that they were made with.

        Raises:
            Refused: The actor may not back up, or the passphrase is too short or too long.
        """
        require(actor, "backup")
        key = new_key(passphrase)
        self._catalogue.set(Setting(key=KEY, content=key_to_json(key), by=actor.name))
        self._audit.note(actor, "set backup passphrase")
        return key

    def last(self) -> MadeBackup | None:
        """The newest backup that was made, None before the first."""
        kept = self._catalogue.setting(LAST)
        return None if kept is None else msgspec.json.decode(kept.content, type=MadeBackup)

    def make(self, actor: Account, target: Path) -> MadeBackup:
        """Write a backup; the file is whole or absent. The list of erased patients is put beside it.

        Args:
            actor: Who makes it (verb "backup").
            target: New file.

        Raises:
            Refused: The actor may not, no passphrase is set, the target exists or cannot be written.
        """
        require(actor, "backup")
        _check_target(target, self._folder.root)
        working = target.with_name(f".{target.name}.part")
        try:
            with open(os.open(working, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600), "wb") as file:
                made = self.stream(actor, file)
                file.flush()
                os.fsync(file.fileno())
            os.replace(working, target)
            add_to_ledger(target.with_name(LEDGER), ledger(self._folder.root / LEDGER))
        except OSError as error:
            raise Refused(
                f"backup {target}",
                f"not written ({error.strerror or error})",
                "in a place with space that can be written",
                "choose another place",
            ) from error
        finally:
            working.unlink(missing_ok=True)
        return made

    def stream(self, actor: Account, target: IO[bytes]) -> MadeBackup:
        """Write a backup into an open file.

        Raises:
            Refused: The actor may not, or no passphrase is set.
            OSError: The target cannot be written.
        """
        require(actor, "backup")
        key = self.key()
        if key is None:
            raise Refused("backup passphrase", "not set", "set once by an administrator", "set it first")
        with tempfile.TemporaryDirectory(dir=self._folder.root, prefix=".backup-") as aside:
            copy = Path(aside) / FILE
            self._catalogue.copy_to(copy)
            counted = _Counting(target)
            manifest = write_archive(
                cast("IO[bytes]", counted), self._parts(copy), key, self._software, self._clock_ns()
            )
        made = MadeBackup(manifest.utc_ns, len(manifest.sha256), counted.tell(), actor.name)
        self._catalogue.set(Setting(key=LAST, content=msgspec.json.encode(made).decode(), by=actor.name))
        self._audit.note(actor, "backup", "", f"{made.files} files, {made.bytes} bytes")
        return made

    def _parts(self, copy: Path) -> Iterator[Part]:
        """Everything that is sealed, in a fixed order; what is being recorded now is not whole yet."""
        root = self._folder.root
        yield Part(FILE, copy)
        for folder in (self._folder.takes, self._folder.sessions, self._folder.reports):
            for path in sorted(folder.rglob("*")):
                whole = path.is_file() and not path.is_symlink() and not path.name.startswith(".")
                if whole and ".partial." not in path.name:
                    yield Part(path.relative_to(root).as_posix(), path)
        for path in (self._folder.secret, root / LEDGER):
            if path.exists():
                yield Part(path.name, path)


def _check_target(target: Path, root: Path) -> None:
    if target.exists():
        raise Refused(f"backup {target}", "there already", "a new file", "choose another name")
    if not target.parent.is_dir():
        raise Refused("folder of the backup", f"{target.parent}, which is not there", "a folder", "make it")
    if target.resolve().is_relative_to(root.resolve()):
        raise Refused(
            f"backup {target}",
            "inside the clinic folder",
            "outside it, best on another disk",
            "choose another place",
        )


class _Counting:
    """A file that is written, with how much was written; a zip is written front to back."""

    def __init__(self, file: IO[bytes]) -> None:
        self._file = file
        self._written = 0

    def write(self, block: bytes) -> int:
        self._file.write(block)
        self._written += len(block)
        return len(block)

    def tell(self) -> int:
        return self._written

    def flush(self) -> None:
        self._file.flush()
