"""Today's passive run: which of the files of one patient and day may be taken off a session."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from pathlib import Path

from sessions.errors import Refused
from sessions.metrics import Summary, measure_file
from sessions.metrics.separated import unlike
from sessions.reports.possible import possible
from sessions.store import SessionReader


def measure_beside(path: Path, candidates: Sequence[Path]) -> Summary:
    """All numbers of a sealed file, with the first passive run that is of the same hand, day and device.

    Args:
        path: A take or therapy session.
        candidates: Passive runs of the same patient, the likeliest first; unreadable ones are passed over.

    Raises:
        Refused: The file cannot be read, or lacks what its kind needs.
    """
    return possible(measure_file(path, fitting(path, candidates)))


def fitting(path: Path, candidates: Sequence[Path]) -> Path | None:
    """The first passive run that is of the same hand, day and device as a session, None without one.

    Raises:
        Refused: The session cannot be read.
    """
    if not candidates:
        return None
    with SessionReader(path) as reader:
        header = reader.header
    for candidate in candidates:
        try:
            with SessionReader(candidate) as reader:
                fits = not unlike(reader.header, header)
        except Refused:
            continue
        if fits:
            return candidate
    return None


def named_by_digest(digest: str, folder: Path) -> Path:
    """The recording in a folder that has this digest.

    Raises:
        Refused: There is none.
    """
    for path in sorted(folder.glob("*.mcap")):
        note = path.with_name(f"{path.name}.sha256")
        if note.is_file() and digest.encode() not in note.read_bytes()[:200]:
            continue
        with path.open("rb") as file:
            if hashlib.file_digest(file, "sha256").hexdigest() == digest:
                return path
    raise Refused(
        "passive run of the report",
        f"not found ({digest[:12]})",
        "beside the session",
        "put the file with that SHA-256 into the session's folder",
    )
