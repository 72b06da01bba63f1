"""The sealed files of a clinic that may lie in an object store, found on the disk and in the catalogue."""

from __future__ import annotations

import os
from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass
from pathlib import Path

from rehab_app.config import ClinicFolder
from rehab_app.errors import Refused
from rehab_app.services.object_queue import Act, Errand, Kind
from rehab_app.services.storage import SUFFIX
from sessions.catalogue import Catalogue
from sessions.store import PARTIAL_SUFFIX
from sessions.store.integrity import noted_digest
from sessions.store.refusals import refusing


@dataclass(frozen=True, slots=True)
class Sealed:
    """One sealed file.

    Attributes:
        kind: Room that it lies in.
        sha256: Its digest.
        path: Where it lies, or lay.
    """

    kind: Kind
    sha256: str
    path: Path

    def relative(self, root: Path) -> str:
        """Its path within the clinic folder."""
        return self.path.relative_to(root).as_posix()

    def errand(self, act: Act) -> Errand:
        """An errand for it."""
        return Errand(act, self.kind, self.sha256, f"{self.kind}/{self.path.name}" if act == "put" else "")


def sealed_files(
    folder: ClinicFolder,
    catalogue: Catalogue,
    besides: Collection[Path] = frozenset(),
    settled: Callable[[Kind, str], bool] = lambda kind, sha256: False,
) -> Iterator[Sealed]:
    """Sealed files on the disk that the catalogue knows.

    Args:
        folder: The clinic folder.
        catalogue: Its catalogue.
        besides: Paths that are passed over, without a look into them.
        settled: Whether a room and digest are passed over, without a question to the catalogue.
    """
    rooms: tuple[tuple[Kind, Path], ...] = (("sessions", folder.sessions), ("takes", folder.takes))
    for kind, room in rooms:
        for name in sorted(os.listdir(room)):
            path = room / name
            if not name.endswith(SUFFIX) or name.endswith(PARTIAL_SUFFIX) or name.startswith("."):
                continue
            if path in besides:
                continue
            known = _known(catalogue, kind, path, settled)
            if known is not None:
                yield known


def sealed_named(folder: ClinicFolder, catalogue: Catalogue, named: str) -> Sealed:
    """A session or take of the catalogue, whether its file is here or not.

    Args:
        folder: The clinic folder.
        catalogue: Its catalogue.
        named: Id or digest.

    Raises:
        Refused: There is none.
    """
    try:
        session = catalogue.session(named)
        return Sealed("sessions", session.sha256, folder.root / session.path)
    except Refused:
        pass
    try:
        take = catalogue.take(named)
    except Refused as refusal:
        raise Refused(
            f"session or take {named!r}", "unknown", "the id of one in this clinic", "check the id"
        ) from refusal
    return Sealed("takes", take.sha256, folder.root / take.path)


def _known(
    catalogue: Catalogue, kind: Kind, path: Path, settled: Callable[[Kind, str], bool]
) -> Sealed | None:
    """A file with its digest as it was noted at sealing, None where the catalogue does not have it."""
    try:
        with refusing(path):
            sha256 = noted_digest(path)
        if sha256 is None or settled(kind, sha256):
            return None
        held = catalogue.session(sha256) if kind == "sessions" else catalogue.take(sha256)
    except Refused:
        return None
    return Sealed(kind, sha256, path) if Path(held.path).name == path.name else None
