"""Verbs of the audit."""

from __future__ import annotations

from sqlalchemy import select

from sessions.catalogue import audit
from sessions.catalogue.ledger import Ledger
from sessions.catalogue.records import AuditRow
from sessions.catalogue.rows import value_of
from sessions.catalogue.tables import AuditTableRow


class Trail(Ledger):
    """The audit."""

    def record_audit(self, actor: str, verb: str, subject: str, detail: str = "") -> AuditRow:
        """Append to the audit; never name a patient in ``detail``."""
        with self._writing() as session:
            last = session.scalar(select(AuditTableRow).order_by(AuditTableRow.seq.desc()).limit(1))
            row = audit.chained(
                value_of(AuditRow, last) if last else None,
                utc_ns=self._clock_ns(),
                actor=actor,
                verb=verb,
                subject=subject,
                detail=detail,
            )
            session.add(
                AuditTableRow(
                    row.seq,
                    row.utc_ns,
                    row.actor,
                    row.verb,
                    row.subject,
                    row.detail,
                    row.previous_hash,
                    row.hash,
                )
            )
            return row

    def audit(self, limit: int = 200) -> tuple[AuditRow, ...]:
        """The last rows of the audit, newest first."""
        with self._reading() as session:
            rows = session.scalars(select(AuditTableRow).order_by(AuditTableRow.seq.desc()).limit(limit))
            return tuple(value_of(AuditRow, row) for row in rows)

    def verify_audit(self) -> int:
        """Follow the whole chain and count its rows.

        Raises:
            Refused: A row was changed, removed or slipped in.
        """
        with self._reading() as session:
            rows = session.scalars(select(AuditTableRow).order_by(AuditTableRow.seq))
            return audit.verify(value_of(AuditRow, row) for row in rows)
