"""What lists offer for choice in a catalogue of any size: a few patients or takes, and how many there are."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

from sqlalchemy import ColumnElement, Select, func, or_, select
from sqlalchemy.orm import Session

from sessions.catalogue.clinic_tables import PatientEntryRow
from sessions.catalogue.ledger import Ledger
from sessions.catalogue.records import Patient, Take
from sessions.catalogue.rows import values_of
from sessions.catalogue.tables import ApprovalRow, PatientRow, TakeRow, TherapySessionRow
from sessions.catalogue.take_filter import TakeFilter, TakeWord
from sessions.catalogue.texts import storable

_PLAN = "plan"
_NEWEST_SESSIONS, _NEWEST_ENTRIES = 600, 2000
"""How far back is looked for whom somebody works with: more would cost time and bring nobody in mind."""
_AT_ONCE = 500


class Choices(Ledger):
    """A few of many: patients that somebody works with, takes that fit."""

    def recent_patients(self, count: int) -> tuple[tuple[Patient, ...], int]:
        """Patients lately treated, prescribed for or added, the latest first, and how many there are in all.

        Where there are no more than ``count``, all of them by pseudonym. The archived are left out.
        """
        here = PatientRow.archived.expression.is_(False)
        with self._reading() as session:
            total = session.scalar(select(func.count()).select_from(PatientRow).where(here)) or 0
            query = select(PatientRow).where(here).order_by(PatientRow.number)
            if total <= count:
                return values_of(session, Patient, query), total
            latest_ns = _latest_ns(session, count)
            found: list[Patient] = []
            for part in _parts(latest_ns):
                found += values_of(session, Patient, query.where(PatientRow.id.in_(part)))
            return tuple(sorted(found, key=lambda one: -latest_ns[one.id])[:count]), total

    def lately_treated(self) -> tuple[str, ...]:
        """Pseudonyms of the patients of the newest sessions, the last one first."""
        with self._reading() as session:
            rows = session.execute(_newest_treated())
            return tuple(dict.fromkeys(patient for patient, _ in rows if patient))

    def find_takes(self, wanted: TakeFilter, start: int, count: int) -> tuple[tuple[Take, ...], int]:
        """Takes that fit, newest first, and how many fit in all."""
        asked = (wanted.exercise, wanted.side, wanted.subject, wanted.parent)
        if not all(storable(text) for text in (*asked, *(word.text for word in wanted.words))):
            return (), 0
        conditions = _conditions(wanted)
        with self._reading() as session:
            total = session.scalar(select(func.count()).select_from(TakeRow).where(*conditions)) or 0
            query = select(TakeRow).where(*conditions)
            newest = query.order_by(TakeRow.created_utc_ns.desc(), TakeRow.id)
            return values_of(session, Take, newest.offset(start).limit(count)), total

    def take_counts(self, *, approved: bool = False) -> dict[str, int]:
        """How many takes there are by exercise, that of the newest first; of the approved on demand."""
        newest = func.max(TakeRow.created_utc_ns)
        query = select(TakeRow.exercise, func.count()).group_by(TakeRow.exercise)
        if approved:
            query = query.where(TakeRow.id.in_(_approved()))
        with self._reading() as session:
            rows = session.execute(query.order_by(newest.desc(), TakeRow.exercise))
            return {exercise: number for exercise, number in rows}

    def demonstrators(self, count: int) -> tuple[Patient, ...]:
        """Patients of the clinic whose own hands were recorded, by pseudonym; the archived are left out."""
        query = select(PatientRow).where(
            PatientRow.archived.expression.is_(False),
            PatientRow.id.in_(select(TakeRow.subject_id)),
        )
        with self._reading() as session:
            return values_of(session, Patient, query.order_by(PatientRow.number).limit(count))

    def patients_named(self, pseudonyms: tuple[str, ...]) -> tuple[Patient, ...]:
        """Patients of these pseudonyms, as far as there are any; the archived are left out."""
        found: list[Patient] = []
        with self._reading() as session:
            for part in _parts(pseudonyms):
                query = select(PatientRow).where(
                    PatientRow.id.in_(part), PatientRow.archived.expression.is_(False)
                )
                found += values_of(session, Patient, query)
        return tuple(found)


def _latest_ns(session: Session, count: int) -> dict[str, int]:
    """When something was last done about a patient, UTC ns; of those about whom something was done lately."""
    newest = (
        select(PatientEntryRow.patient, PatientEntryRow.created_utc_ns, PatientEntryRow.kind)
        .order_by(PatientEntryRow.id.desc())
        .limit(_NEWEST_ENTRIES)
        .subquery()
    )
    prescribed = select(newest.c.patient, newest.c.created_utc_ns).where(newest.c.kind == _PLAN)
    added = (
        select(PatientRow.id, PatientRow.created_utc_ns)
        .where(PatientRow.archived.expression.is_(False))
        .order_by(PatientRow.number.desc())
        .limit(count)
    )
    latest: dict[str, int] = {}
    for query in (_newest_treated(), prescribed, added):
        for patient, utc_ns in session.execute(query):
            latest[patient] = max(utc_ns, latest.get(patient, 0))
    return latest


def _newest_treated() -> Select[str | None, int]:
    """Patients of the newest sessions and when those began, newest first."""
    return (
        select(TherapySessionRow.patient, TherapySessionRow.started_utc_ns)
        .where(TherapySessionRow.patient.is_not(None))
        .order_by(TherapySessionRow.started_utc_ns.desc())
        .limit(_NEWEST_SESSIONS)
    )


def _approved() -> Select[Any]:
    """Ids of the takes whose newest word is an approval of the very file."""
    known = select(func.max(ApprovalRow.id)).join(TakeRow, TakeRow.id == ApprovalRow.take)
    newest = known.where(ApprovalRow.digest.in_((TakeRow.sha256, ""))).group_by(ApprovalRow.take)
    return select(ApprovalRow.take).where(ApprovalRow.id.in_(newest), ApprovalRow.digest != "")


def _conditions(wanted: TakeFilter) -> list[ColumnElement[bool]]:
    column: Any = TakeRow
    asked = {
        "exercise": wanted.exercise,
        "side": wanted.side,
        "subject_id": wanted.subject,
        "parent": wanted.parent,
    }
    conditions: list[ColumnElement[bool]] = [
        getattr(column, name) == value for name, value in asked.items() if value
    ]
    if wanted.approved is not None:
        approved = TakeRow.id.in_(_approved())
        conditions.append(approved if wanted.approved else ~approved)
    return conditions + [_means(word) for word in wanted.words]


def _means(word: TakeWord) -> ColumnElement[bool]:
    """Whether a word means a take: a name that it holds is that of a patient who is not archived."""
    named = select(PatientRow.id).where(
        PatientRow.archived.expression.is_(False),
        PatientRow.sought.contains(word.text, autoescape=True),
    )
    return or_(
        TakeRow.exercise.in_(word.exercises),
        TakeRow.side.in_(word.sides),
        TakeRow.id.startswith(word.text, autoescape=True),
        func.lower(TakeRow.subject_id) == word.text,
        TakeRow.subject_id.in_(named),
    )


def _parts(names: Collection[str]) -> list[tuple[str, ...]]:
    """So many as one statement may name."""
    every = tuple(names)
    return [every[start : start + _AT_ONCE] for start in range(0, len(every), _AT_ONCE)]
