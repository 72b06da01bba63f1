"""The folder in which backups that are made in the browser lie, and from which one is restored."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

from rehab_app.access import Account, require
from rehab_app.config import ClinicFolder
from rehab_app.errors import Refused
from rehab_app.services.audit import Audit
from rehab_app.services.backup import SUFFIX, Backups
from rehab_app.services.erased_ledger import LEDGER
from rehab_app.services.restoring import Restored, restore
from sessions.catalogue import Catalogue, Setting

PLACE = "backup folder"


class BackupPlace:
    """Stored backups.

    Args:
        folder: The clinic folder.
        catalogue: Its catalogue.
        backups: What makes them.
        audit: Where choices and restores are noted.
        clock_ns: UTC in ns.
    """

    def __init__(
        self,
        folder: ClinicFolder,
        catalogue: Catalogue,
        backups: Backups,
        audit: Audit,
        clock_ns: Callable[[], int] = time.time_ns,
    ) -> None:
        self._root = folder.root
        self._catalogue = catalogue
        self._backups = backups
        self._audit = audit
        self._clock_ns = clock_ns

    def place(self) -> Path:
        """Folder on this machine where the browser's backups go; by default beside the clinic folder."""
        kept = self._catalogue.setting(PLACE)
        root = self._root
        return root.with_name(root.name + "-backups") if kept is None else Path(kept.content)

    def set_place(self, actor: Account, place: Path) -> None:
        """Choose that folder; it is made where it does not exist.

        Raises:
            Refused: The actor may not back up, or the folder cannot be used.
        """
        require(actor, "backup")
        if not place.is_absolute() or place.resolve().is_relative_to(self._root.resolve()):
            bound = "a full path outside the clinic folder, best on another disk"
            raise Refused("backup folder", str(place)[:200] or "empty", bound, "name another")
        _made(place)
        self._catalogue.set(Setting(key=PLACE, content=str(place), by=actor.name))
        self._audit.note(actor, "set backup folder")

    def stored(self) -> tuple[Path, ...]:
        """Backups in that folder, newest first."""
        return tuple(sorted(self.place().glob(f"*{SUFFIX}"), reverse=True))

    def stored_named(self, name: str) -> Path:
        """One of them by its name.

        Raises:
            Refused: There is none.
        """
        for path in self.stored():
            if path.name == name:
                return path
        raise Refused(f"backup {name[:80]!r}", "unknown", "one of the list", "choose it from the list")

    def make_stored(self, actor: Account) -> Path:
        """Back up into that folder, under the time of now.

        Raises:
            Refused: As of ``make``.
        """
        stamp = time.strftime("%Y%m%dT%H%M%SZ", time.gmtime(self._clock_ns() // 1_000_000_000))
        target = _made(self.place()) / f"{stamp}{SUFFIX}"
        self._backups.make(actor, target)
        return target

    def restore_beside(self, actor: Account, name: str, passphrase: str) -> Restored:
        """Restore a stored backup into a new folder beside the clinic, which goes on as it is.

        Raises:
            Refused: The actor may not, there is no such backup, or as of ``restore``.
        """
        require(actor, "backup")
        source, root = self.stored_named(name), self._root
        target = root.with_name(f"{root.name}-restored-{source.name.removesuffix(SUFFIX)}")
        restored = restore(source, ClinicFolder(target), passphrase, root / LEDGER)
        self._audit.note(actor, "restore backup", "", source.name)
        return restored


def _made(place: Path) -> Path:
    try:
        place.mkdir(mode=0o700, parents=True, exist_ok=True)
    except OSError as error:
        value = f"{place} ({error.strerror})"
        raise Refused("backup folder", value, "a folder that can be written", "name another") from error
    return place
