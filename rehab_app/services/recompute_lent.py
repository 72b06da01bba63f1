"""Files that lie in the object store only, brought back for as long as they are measured."""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from rehab_app.errors import REFUSALS, Refused
from rehab_app.services.object_rooms import Sealed
from rehab_app.services.recompute_work import Work
from sessions.store.integrity import noted_digest

_AT_ONCE = 16
"""So many files of the store are on the disk at a time: whoever evicted them was short of room."""


@dataclass(slots=True)
class Lent:
    """Files of a part of the work.

    Attributes:
        here: What can be measured.
        refused: Why the others cannot, by catalogue id.
    """

    here: list[Work] = field(default_factory=list[Work])
    refused: dict[str, str] = field(default_factory=dict[str, str])


def parts_of(works: Sequence[Work]) -> tuple[Sequence[Work], ...]:
    """Everything whose files are here, then the rest a few at a time."""
    here = [work for work in works if not _missing(work)]
    away = [work for work in works if _missing(work)]
    parts = [here, *(away[start : start + _AT_ONCE] for start in range(0, len(away), _AT_ONCE))]
    return tuple(part for part in parts if part)


@contextmanager
def lent(works: Sequence[Work], bring: Callable[[Sealed], None] | None) -> Generator[Lent]:
    """The files of some work are on the disk until the block ends; those that were there stay.

    Args:
        works: What is to be measured.
        bring: Brings a file back, proven by its digest; None where there is no object store.
    """
    found, brought = Lent(), list[Path]()
    try:
        for work in works:
            try:
                if bring is not None:
                    _bring(work, bring, brought)
                found.here.append(work)
            except REFUSALS as refusal:
                found.refused[work.id] = str(refusal)
        yield found
    finally:
        for path in brought:
            path.unlink(missing_ok=True)


def _bring(work: Work, bring: Callable[[Sealed], None], brought: list[Path]) -> None:
    for path in _missing(work):
        sha256 = work.sha256 if path == work.path else noted_digest(path)
        if sha256 is None:
            value = "without the digest beside it that it was sealed with"
            raise Refused(f"file {path.name!r}", value, "as it was left", "fetch it with rehab-app store")
        bring(Sealed("sessions" if path.parent.name == "sessions" else "takes", sha256, path))
        brought.append(path)


def _missing(work: Work) -> list[Path]:
    return [path for path in (work.path, *work.passive) if not path.exists()]
