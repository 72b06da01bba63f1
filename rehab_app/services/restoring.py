"""Restores a backup as a new clinic folder, without the patients who were erased since."""

from __future__ import annotations

import os
import shutil
from dataclasses import dataclass
from pathlib import Path

from rehab_app.access import CONSOLE
from rehab_app.config import ClinicFolder
from rehab_app.errors import Refused
from rehab_app.services.audit import Audit
from rehab_app.services.backup_archive import Manifest, read_archive
from rehab_app.services.erased_ledger import LEDGER
from rehab_app.services.erasure import Erasures
from sessions.catalogue import Catalogue


@dataclass(frozen=True, slots=True)
class Restored:
    """A clinic that was restored.

    Attributes:
        folder: Where it is now.
        manifest: What the backup held.
        erased_again: Pseudonyms that had been erased after the backup.
        audit_rows: Rows of the audit, whose chain is whole.
    """

    folder: Path
    manifest: Manifest
    erased_again: tuple[str, ...]
    audit_rows: int


def restore(source: Path, folder: ClinicFolder, passphrase: str, *ledgers: Path) -> Restored:
    """Restore a backup as a new clinic folder; the folder is whole or as it was before.

    Args:
        source: The backup. A list of erased patients beside it counts.
        folder: Where to; it is empty or does not exist.
        passphrase: The one that was set when the backup was made.
        ledgers: Further lists of erased patients.

    Raises:
        Refused: There is no such file, the folder is not empty, the passphrase is wrong, the backup was cut
            or changed, or the disk is full.
    """
    root = folder.root
    _check(source, root)
    aside = ClinicFolder(root.with_name(f".{root.name}.restoring"))
    shutil.rmtree(aside.root, ignore_errors=True)
    try:
        aside.create()
        manifest = read_archive(source, aside.root, passphrase)
        again, rows = _forget(aside, source.with_name(LEDGER), *ledgers)
        if root.exists():
            root.rmdir()
        os.replace(aside.root, root)
    except OSError as error:
        raise Refused(
            f"folder {root}",
            f"not written ({error.strerror or error})",
            "in a place with space that can be written",
            "choose another with --data",
        ) from error
    finally:
        shutil.rmtree(aside.root, ignore_errors=True)
    return Restored(root, manifest, again, rows)


def _check(source: Path, root: Path) -> None:
    if not source.is_file():
        raise Refused(f"backup {source}", "not there", "a file made by rehab-app backup", "check its name")
    if root.exists() and (not root.is_dir() or any(root.iterdir())):
        raise Refused(f"folder {root}", "not empty", "a new or empty folder", "name another with --data")


def _forget(folder: ClinicFolder, *ledgers: Path) -> tuple[tuple[str, ...], int]:
    """Erase again whom the lists name; the catalogue is brought to the newest schema on the way."""
    with Catalogue.open(folder.root) as catalogue:
        rows = catalogue.verify_audit()
        return Erasures(folder, catalogue, Audit(catalogue)).erase_again(CONSOLE, *ledgers), rows
