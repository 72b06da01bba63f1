"""Takes as lists show them: found by filter and words, page by page, without reading them all."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path

from rehab_app.errors import NoAnswer, Refused
from rehab_app.services.patients import FOR_CHOICE
from rehab_app.services.rows import TakeRow
from sessions.catalogue import Approval, Catalogue, Patient, Take, TakeFilter
from sessions.records import Side

ON_A_PAGE = 50


@dataclass(frozen=True, slots=True)
class FoundTakes:
    """A page of takes that were looked for.

    Attributes:
        takes: Those of this page, newest first.
        total: How many there are on all pages.
        page: Number of this page, from 1.
        pages: Number of pages, at least 1.
    """

    takes: tuple[TakeRow, ...]
    total: int
    page: int
    pages: int


class TakeShelf:
    """Finds takes.

    Args:
        root: The clinic folder.
        catalogue: Its catalogue.
    """

    def __init__(self, root: Path, catalogue: Catalogue) -> None:
        self._root = root
        self._catalogue = catalogue

    def find(self, wanted: TakeFilter, page: int = 1, on_a_page: int = ON_A_PAGE) -> FoundTakes:
        """Takes that fit, newest first.

        Args:
            wanted: What they must be.
            page: Number of the page, from 1; the last one where there are fewer.
            on_a_page: How many stand on one.
        """
        start = on_a_page * max(page - 1, 0)
        found, total = self._catalogue.find_takes(wanted, start, on_a_page)
        pages = max(1, math.ceil(total / on_a_page))
        if page > pages:
            return self.find(wanted, pages, on_a_page)
        return FoundTakes(self._rows(found), total, max(page, 1), pages)

    def choice(self, wanted: TakeFilter, kept: str = "") -> FoundTakes:
        """A few approved takes for a list to choose from.

        Args:
            wanted: What they must be; approved in any case.
            kept: Id of a take that is in the list in any case where it is approved: the one chosen already.
        """
        found = self.find(replace(wanted, approved=True), on_a_page=FOR_CHOICE)
        if not kept or any(row.id == kept for row in found.takes):
            return found
        row = self.named(kept)
        if row is None or row.approved_by is None:
            return found
        return replace(found, takes=(row, *found.takes))

    def named(self, take: str) -> TakeRow | None:
        """The take of exactly this id, None where there is none."""
        try:
            found = self._catalogue.take(take)
        except NoAnswer:
            raise
        except Refused:
            return None
        return self._rows((found,))[0] if found.id == take else None

    def newest(self, exercise: str, side: Side) -> TakeRow | None:
        """The newest approved take of an exercise, one of this side first; None where there is none."""
        for which in (side, ""):
            wanted = TakeFilter(exercise=exercise, side=which, approved=True)
            found, _ = self._catalogue.find_takes(wanted, 0, 1)
            if found:
                return self._rows(found)[0]
        return None

    def counts(self, *, approved: bool = False) -> dict[str, int]:
        """How many takes there are of each exercise, that of the newest first; of the approved on demand."""
        return self._catalogue.take_counts(approved=approved)

    def demonstrators(self) -> tuple[Patient, ...]:
        """Patients whose own hands were recorded; none where there are too many for a list."""
        found = self._catalogue.demonstrators(FOR_CHOICE + 1)
        return found if len(found) <= FOR_CHOICE else ()

    def people(self, rows: tuple[TakeRow, ...]) -> dict[str, Patient]:
        """Patients of the clinic whose hands these takes are, by pseudonym."""
        named = tuple(sorted({row.subject for row in rows if row.subject}))
        return {one.id: one for one in self._catalogue.patients_named(named)} if named else {}

    def _rows(self, takes: tuple[Take, ...]) -> tuple[TakeRow, ...]:
        approved = self._catalogue.approvals(tuple(take.id for take in takes)) if takes else {}
        return tuple(take_row(self._root, take, approved.get(take.id)) for take in takes)


def take_row(root: Path, take: Take, approval: Approval | None) -> TakeRow:
    """A take as a list shows it.

    Args:
        root: The clinic folder.
        take: The take.
        approval: The approval that holds, None where there is none.
    """
    return TakeRow(
        id=take.id,
        path=root / take.path,
        sha256=take.sha256,
        side=take.side,
        exercise=take.exercise,
        source=take.source,
        duration_s=take.duration_s,
        created_utc_ns=take.created_utc_ns,
        approved_by=None if approval is None else approval.by,
        parent=take.parent,
        author=take.author,
        reason=take.reason,
        subject=take.subject_id,
        retouch=take.retouch,
    )
