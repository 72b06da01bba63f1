"""Verbs of the audit."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import fields
from typing import Any

from sqlalchemy import ColumnElement, func, select
from sqlalchemy.orm import Session

from sessions.catalogue import audit
from sessions.catalogue.audit import START, ChainEnd
from sessions.catalogue.audit_filter import AuditFilter
from sessions.catalogue.ledger import Ledger
from sessions.catalogue.records import AuditRow
from sessions.catalogue.rows import value_of
from sessions.catalogue.tables import AuditTableRow
from sessions.catalogue.texts import storable


class Trail(Ledger):
    """The audit."""

    def record_audit(self, actor: str, verb: str, subject: str, detail: str = "") -> AuditRow:
        """Append to the audit; never name a patient in ``detail``."""
        return self.record_audit_rows([(actor, verb, subject, detail)])[-1]

    def record_audit_rows(self, rows: Iterable[tuple[str, str, str, str]]) -> tuple[AuditRow, ...]:
        """Append several rows in one transaction, each (actor, verb, subject, detail)."""
        with self._writing() as session:
            newest = session.scalar(select(AuditTableRow).order_by(AuditTableRow.seq.desc()).limit(1))
            last = value_of(AuditRow, newest) if newest else None
            added: list[AuditRow] = []
            for actor, verb, subject, detail in rows:
                last = audit.chained(
                    last, utc_ns=self._clock_ns(), actor=actor, verb=verb, subject=subject, detail=detail
                )
                added.append(last)
                session.add(_table_row(last))
            return tuple(added)

    def audit(self, limit: int = 200) -> tuple[AuditRow, ...]:
        """The last rows of the audit, newest first."""
        with self._reading() as session:
            rows = session.scalars(select(AuditTableRow).order_by(AuditTableRow.seq.desc()).limit(limit))
            return tuple(value_of(AuditRow, row) for row in rows)

    def find_audit(self, wanted: AuditFilter, start: int, count: int) -> tuple[tuple[AuditRow, ...], int]:
        """Rows that fit, newest first, and how many fit in all."""
        if not all(storable(text) for text in (wanted.actor, wanted.verb, wanted.subject)):
            return (), 0
        conditions = _conditions(wanted)
        with self._reading() as session:
            total = session.scalar(select(func.count()).select_from(AuditTableRow).where(*conditions)) or 0
            query = select(AuditTableRow).where(*conditions).order_by(AuditTableRow.seq.desc())
            rows = session.scalars(query.offset(start).limit(count))
            return tuple(value_of(AuditRow, row) for row in rows), total

    def audit_words(self, after: int = 0) -> tuple[frozenset[str], frozenset[str], int]:
        """Actors and verbs of the audit, and the number of its newest row.

        Args:
            after: Only of rows with a higher number; by default of all.
        """
        newer = AuditTableRow.seq > after
        with self._reading() as session:
            newest = session.scalar(select(func.max(AuditTableRow.seq))) or 0
            actors = session.scalars(select(AuditTableRow.actor).where(newer).distinct())
            verbs = session.scalars(select(AuditTableRow.verb).where(newer).distinct())
            return frozenset(actors), frozenset(verbs), newest

    def verify_audit(self) -> int:
        """Follow the whole chain and count its rows.

        Raises:
            Refused: A row was changed, removed or slipped in.
        """
        return self.follow_audit().rows

    def follow_audit(self, after: ChainEnd = START) -> ChainEnd:
        """Follow the chain from where it was followed before.

        What was followed before must still have as many rows, and the last of them must be the same; whether
        one between was changed meanwhile, only following the whole chain tells.

        Args:
            after: How far it was followed before; by default from its beginning.

        Returns:
            Its end now.

        Raises:
            Refused: A row that follows, or the last of those before, was changed, removed or slipped in.
        """
        columns = (getattr(AuditTableRow, field.name) for field in fields(AuditRow))
        # a chain of years is read in pieces, and no row object is made of it
        query = select(*columns).order_by(AuditTableRow.seq).execution_options(yield_per=1000)
        with self._reading() as session:
            if after.rows:
                _check_end(session, after)
                query = query.where(AuditTableRow.seq > after.rows)
            with session.execute(query) as rows:
                return audit.follow((AuditRow(**row) for row in rows.mappings()), after)


def _check_end(session: Session, end: ChainEnd) -> None:
    """Refuse a chain whose followed part has other rows than it had, or another end.

    Raises:
        Refused: It has.
    """
    followed = select(func.count()).select_from(AuditTableRow).where(AuditTableRow.seq <= end.rows)
    last = session.get(AuditTableRow, end.rows)
    if last is None or last.hash != end.head or not audit.is_itself(value_of(AuditRow, last)):
        raise audit.broken(end.rows, end.rows)
    if session.scalar(followed) != end.rows:
        raise audit.broken(end.rows, end.rows)


def _table_row(row: AuditRow) -> AuditTableRow:
    return AuditTableRow(
        row.seq, row.utc_ns, row.actor, row.verb, row.subject, row.detail, row.previous_hash, row.hash
    )


def _conditions(wanted: AuditFilter) -> list[ColumnElement[bool]]:
    column: Any = AuditTableRow
    conditions: list[ColumnElement[bool]] = []
    for name in ("actor", "verb", "subject"):
        value = getattr(wanted, name)
        if value:
            conditions.append(getattr(column, name) == value)
    if wanted.from_utc_ns:
        conditions.append(AuditTableRow.utc_ns >= wanted.from_utc_ns)
    if wanted.until_utc_ns:
        conditions.append(AuditTableRow.utc_ns < wanted.until_utc_ns)
    return conditions
