"""Recordings that an ended server left unsealed: restored and entered at the next start, and said."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path

import msgspec

from rehab_app.access import CONSOLE
from rehab_app.config import ClinicFolder
from rehab_app.errors import NoAnswer, Refused
from rehab_app.services.audit import Audit
from rehab_app.services.left_over import sweep, unentered
from rehab_app.services.takes import Takes
from sessions.catalogue import Catalogue, TherapySession
from sessions.records import SessionHeader
from sessions.store import SealedSession, SessionReader, partials, recover, verify

_WHO = "start of the server"


@dataclass(frozen=True, slots=True)
class Restored:
    """A recording that was interrupted.

    Attributes:
        kind: "takes" or "sessions", as in addresses of pages; empty where it could not be restored.
        id: Its catalogue id.
        began_utc_ns: When it began, 0 where that is unknown.
        trouble: Why it could not be restored, empty where it was.
    """

    kind: str
    id: str
    began_utc_ns: int
    trouble: str = ""


class _Asked(msgspec.Struct):
    """The part of a kept prescription that the catalogue needs."""

    mode: str = ""


class Interrupted:
    """Restores what was interrupted.

    Args:
        folder: The clinic folder.
        catalogue: Its catalogue.
        takes: Where takes are entered.
        audit: Where restorations are noted.
    """

    def __init__(self, folder: ClinicFolder, catalogue: Catalogue, takes: Takes, audit: Audit) -> None:
        self._folder = folder
        self._catalogue = catalogue
        self._takes = takes
        self._audit = audit
        self._working = threading.Lock()
        self.found: tuple[Restored, ...] = ()

    def restore(self) -> tuple[Restored, ...]:
        """Restore every unsealed recording that no living process writes; the pages show what was found.

        An unsealed file is removed once what it held is sealed and entered; else it stays as it was. A file
        that was sealed but never entered is entered. Forgotten working files are removed.
        """
        with self._working:
            sweep(self._folder)
            waiting = (*partials(self._folder.takes), *partials(self._folder.sessions))
            self._tell(self._one(path, _recovered) for path in waiting)
            with contextlib.suppress(NoAnswer):  # they are found at the next start
                self._tell(self._one(path, _proven) for path in unentered(self._folder, self._catalogue))
            return self.found

    def _tell(self, restored: Iterable[Restored]) -> None:
        """Show what was found; trouble that was told before is not told again."""
        new = [one for one in restored if one not in self.found]
        self.found = (*self.found, *new)

    def _one(self, path: Path, seal: Callable[[Path], SealedSession]) -> Restored:
        try:
            sealed = seal(path)
            restored = self._enter(sealed.path, sealed.sha256)
        except (Refused, OSError) as problem:
            trouble = f"{path.name} was interrupted and could not be restored: {problem}"
            return Restored("", "", 0, trouble)
        if sealed.path != path:
            path.unlink(missing_ok=True)
        self._audit.note_later(_WHO, "restore interrupted recording", restored.id)
        return restored

    def _enter(self, sealed: Path, sha256: str) -> Restored:
        with SessionReader(sealed) as reader:
            header = reader.header
        if header.kind == "take":
            return Restored("takes", self._takes.enter(sealed, "restore", CONSOLE).id, header.utc_start_ns)
        entered = self._catalogue.add_session(
            TherapySession(
                patient=self._patient(header),
                take=self._take(header),
                sha256=sha256,
                path=sealed.relative_to(self._folder.root).as_posix(),
                mode=_mode(header),
                started_utc_ns=header.utc_start_ns,
            )
        )
        return Restored("sessions", entered.id, header.utc_start_ns)

    def _patient(self, header: SessionHeader) -> str:
        """The patient of the catalogue, empty for a demonstration."""
        try:
            return self._catalogue.patient(header.subject_id).id
        except Refused:
            return ""

    def _take(self, header: SessionHeader) -> str:
        return next((row.id for row in self._takes.list() if row.sha256 in header.parents), "")


def _recovered(path: Path) -> SealedSession:
    return recover(path).sealed


def _proven(path: Path) -> SealedSession:
    proof = verify(path)
    return SealedSession(path, proof.sha256, proof.bytes)


def _mode(header: SessionHeader) -> str:
    try:
        return msgspec.json.decode(header.prescription, type=_Asked).mode
    except msgspec.MsgspecError:
        return ""
