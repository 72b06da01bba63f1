"""Measuring again everything that was recorded, where the methods have changed since."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterable, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from functools import partial

import msgspec

from rehab_app.access import Account, require
from rehab_app.config import RecomputeSettings
from rehab_app.errors import Refused
from rehab_app.services.audit import Audit
from rehab_app.services.kept_numbers import KeptNumbers
from rehab_app.services.object_rooms import Sealed
from rehab_app.services.recompute_crew import Crew, dask_crew, local_crew
from rehab_app.services.recompute_lent import lent, parts_of
from rehab_app.services.recompute_run import measure_with
from rehab_app.services.recompute_work import Measured, Work, not_measured
from sessions.catalogue import Catalogue
from sessions.metrics import DEFINITIONS
from sessions.reports.past import past_from_json, past_version


@dataclass(frozen=True, slots=True)
class Trouble:
    """A file without numbers, and why.

    Attributes:
        id: Catalogue id of the session or take.
        reason: Why.
    """

    id: str
    reason: str


@dataclass(frozen=True, slots=True)
class Recomputed:
    """What came of it.

    Attributes:
        version: Version of the methods.
        files: How many were asked for.
        kept: How many of them were of this version before.
        measured: How many were measured now.
        troubles: Those without numbers, by id.
        digest: SHA-256 over the numbers of all others, sorted by their files' digests.
    """

    version: str
    files: int
    kept: int
    measured: int
    troubles: tuple[Trouble, ...]
    digest: str


class Recompute:
    """Re-analysis.

    Args:
        catalogue: Where files are listed and numbers kept.
        numbers: Reads and keeps numbers.
        audit: Where a re-analysis is noted.
        settings: What the installation says of workers and scheduler.
        bring: Brings a file back that lies in the object store only; None where there is none.
    """

    def __init__(
        self,
        catalogue: Catalogue,
        numbers: KeptNumbers,
        audit: Audit,
        settings: RecomputeSettings,
        bring: Callable[[Sealed], None] | None = None,
    ) -> None:
        self._bring = bring
        self._catalogue = catalogue
        self._numbers = numbers
        self._audit = audit
        self._settings = settings

    def run(
        self,
        actor: Account,
        files: Sequence[str] | None,
        *,
        metric: str = "",
        workers: int | None = None,
        scheduler: str | None = None,
        told: Callable[[int, int | None], None] = lambda done, total: None,
    ) -> Recomputed:
        """Measure what has no numbers of the present version; each result is kept as it comes.

        Args:
            actor: Who asks (verb "approve").
            files: Catalogue ids of sessions or takes, None for all.
            metric: The digest is over this metric alone; empty for all.
            workers: Processes of this machine, 0 for one per core, None as the installation says.
            scheduler: Address of a Dask scheduler, empty for this machine, None as the installation says.
            told: Told how many are done, and of how many.

        Raises:
            Refused: The actor may not, an id or metric is unknown, or there is nobody to measure.
        """
        require(actor, "approve")
        _check_metric(metric)
        works = self._works(files)
        before = self._numbers.texts(works)
        missing = [work for work in works if work.sha256 not in before]
        troubles = tuple(self._measure(missing, self._hire(workers, scheduler), told))
        after = self._numbers.texts(works)
        self._audit.note(actor, "recompute", "", f"{len(missing) - len(troubles)} of {len(works)} files")
        return Recomputed(
            past_version(),
            len(works),
            len(works) - len(missing),
            len(missing) - len(troubles),
            tuple(sorted(troubles, key=lambda trouble: trouble.id)),
            digest_of(after, metric),
        )

    def _works(self, files: Sequence[str] | None) -> tuple[Work, ...]:
        sessions, takes = self._catalogue.sessions(), self._catalogue.takes()
        if files is not None:
            wanted = set(files)
            unknown = sorted(wanted - {row.id for row in sessions} - {take.id for take in takes})
            if unknown or not wanted:
                value = ", ".join(unknown) + " unknown" if unknown else "none named"
                raise Refused("sessions", value, "ids of sessions or takes here", "name others, or all")
            sessions = tuple(row for row in sessions if row.id in wanted)
            takes = tuple(take for take in takes if take.id in wanted)
        return (*self._numbers.works(sessions), *self._numbers.take_works(takes))

    def _hire(self, workers: int | None, scheduler: str | None) -> Callable[[], AbstractContextManager[Crew]]:
        address = self._settings.scheduler if scheduler is None else scheduler
        if address and workers is None:
            return partial(dask_crew, address)
        return partial(local_crew, self._settings.workers if workers is None else workers)

    def _measure(
        self,
        works: Sequence[Work],
        hire: Callable[[], AbstractContextManager[Crew]],
        told: Callable[[int, int | None], None],
    ) -> Iterable[Trouble]:
        told(0, len(works))
        for done, answer in enumerate(self._answers(works, hire), start=1):
            kept = self._numbers.keep(answer)
            told(done, len(works))
            if isinstance(kept, str):
                yield Trouble(answer.work.id, kept)
            elif kept.sha256 != answer.work.sha256:
                yield Trouble(answer.work.id, "its file is not the one that was sealed")

    def _answers(
        self, works: Sequence[Work], hire: Callable[[], AbstractContextManager[Crew]]
    ) -> Iterable[Measured]:
        """Files of the disk, then those of the object store, which are here only while they are measured."""
        for part in parts_of(works):
            with lent(part, self._bring) as files:
                yield from (
                    not_measured(work, files.refused[work.id]) for work in part if work.id in files.refused
                )
                yield from measure_with(files.here, hire)


def _check_metric(name: str) -> None:
    if name and name not in DEFINITIONS:
        raise Refused("metric", repr(name), "one of " + ", ".join(sorted(DEFINITIONS)), "correct the name")


def digest_of(texts: dict[str, str], metric: str = "") -> str:
    """SHA-256 over kept numbers in the order of their files' digests.

    Args:
        texts: Kept numbers by digest of the file.
        metric: Only this metric's numbers; empty for all that is kept.
    """
    whole = hashlib.sha256()
    for name in sorted(texts):
        text = texts[name]
        if metric:
            numbers = [one for one in past_from_json(text).numbers if one.name == metric]
            text = msgspec.json.encode(numbers).decode()
        whole.update(f"{name} {hashlib.sha256(text.encode()).hexdigest()}\n".encode())
    return whole.hexdigest()
