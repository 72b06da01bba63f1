"""What an interrupted act leaves in a clinic folder: sealed files never entered, working files forgotten."""

from __future__ import annotations

import shutil
import time
from collections.abc import Iterator
from pathlib import Path

from rehab_app.config import ClinicFolder
from rehab_app.services.outbox_folder import OutboxFolder
from sessions.catalogue import Catalogue
from sessions.store import PARTIAL_SUFFIX

AT_REST_S = 60.0
"""A file is entered by its own act within moments; before that nobody else may do it."""
FORGOTTEN_S = 3600.0
"""Whatever writes a working file has ended after so long without touching it."""
_WORKING = (".*.part", ".backup-*", "*.sha256.new", "*.recovering.partial.mcap", ".*.mcap.*")


def unentered(folder: ClinicFolder, catalogue: Catalogue) -> tuple[Path, ...]:
    """Sealed takes and sessions at rest that the catalogue does not know, oldest first.

    Args:
        folder: The clinic folder.
        catalogue: Its catalogue.
    """
    present = [
        path
        for room in (folder.takes, folder.sessions)
        for path in room.glob("*.mcap")
        if not path.name.endswith(PARTIAL_SUFFIX) and not path.name.startswith(".")
    ]
    if not present:
        return ()
    known = {row.path for row in (*catalogue.takes(), *catalogue.sessions())}
    known |= OutboxFolder(folder.root).recordings()
    found = [path for path in present if path.relative_to(folder.root).as_posix() not in known]
    return tuple(sorted(path for path in found if _untouched_s(path) > AT_REST_S))


def working_files(folder: ClinicFolder) -> tuple[Path, ...]:
    """Working files and folders that no living act uses any more."""
    return tuple(sorted(path for path in _candidates(folder) if _untouched_s(path) > FORGOTTEN_S))


def sweep(folder: ClinicFolder) -> int:
    """Remove them, and say how many there were."""
    found = working_files(folder)
    for path in found:
        if path.is_dir():
            shutil.rmtree(path, ignore_errors=True)
        else:
            path.unlink(missing_ok=True)
    return len(found)


def _candidates(folder: ClinicFolder) -> Iterator[Path]:
    for room in (folder.root, folder.takes, folder.sessions, folder.reports):
        for pattern in _WORKING:
            yield from room.glob(pattern)


def _untouched_s(path: Path) -> float:
    try:
        return time.time() - path.stat().st_mtime
    except OSError:
        return 0.0  # ended and removed in this very moment
