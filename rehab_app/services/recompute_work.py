"""Measuring one file: the same pure function in this process, in one of a pool and on a cluster."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from rehab_app.errors import REFUSALS
from sessions.reports.past import measure_past, past_to_json, past_version


@dataclass(frozen=True, slots=True)
class Work:
    """One file to measure; it crosses to whoever measures.

    Attributes:
        id: Catalogue id of the session or take.
        sha256: Digest of the file that was sealed.
        key: Version under which its numbers are kept.
        path: The file.
        passive: Passive runs of the same patient and day, the likeliest first.
    """

    id: str
    sha256: str
    key: str
    path: Path
    passive: tuple[Path, ...] = ()


@dataclass(frozen=True, slots=True)
class Measured:
    """What came of it.

    Attributes:
        work: What was asked.
        version: Version of the methods where it was measured.
        content: The numbers as the catalogue keeps them, empty where there are none.
        refusal: Why there are none.
    """

    work: Work
    version: str
    content: str = ""
    refusal: str = ""


def measured(work: Work) -> Measured:
    """Measure one file; one that cannot be read says why."""
    try:
        past = measure_past(work.path, work.passive)
    except REFUSALS as refusal:
        return Measured(work, past_version(), refusal=str(refusal))
    return Measured(work, past_version(), past_to_json(past))


def measured_all(works: Sequence[Work]) -> list[Measured]:
    """Measure several files, one after the other."""
    return [measured(work) for work in works]


def not_measured(work: Work, why: str) -> Measured:
    """The answer of whoever did not come to measure."""
    return Measured(work, past_version(), refusal=why)
