"""Verbs about what was ordered and what was done: prescriptions and therapy sessions."""

from __future__ import annotations

from sqlalchemy import func, select

from sessions.catalogue.ledger import Ledger
from sessions.catalogue.records import PrescriptionRow, TherapySession
from sessions.catalogue.rows import (
    by_id,
    patient_row,
    refuse_path,
    relative,
    short_id,
    take_row,
    value_of,
    values_of,
)
from sessions.catalogue.tables import PrescriptionTableRow, TherapySessionRow


class Therapy(Ledger):
    """Prescriptions and therapy sessions."""

    def add_prescription(self, prescription: PrescriptionRow) -> PrescriptionRow:
        """Add what was ordered.

        Raises:
            Refused: Patient or take is unknown.
        """
        with self._writing() as session:
            row = PrescriptionTableRow(
                patient_row(session, prescription.patient).id,
                take_row(session, prescription.take).id,
                prescription.mode,
                prescription.speed,
                prescription.repetitions,
                prescription.stiffness_multiple,
                prescription.limits,
                prescription.content,
                prescription.by,
                self._clock_ns(),
            )
            session.add(row)
            session.flush()
            return value_of(PrescriptionRow, row)

    def prescriptions(self, patient: str) -> tuple[PrescriptionRow, ...]:
        """Everything that was ordered for a patient, newest first.

        Raises:
            Refused: No patient has that pseudonym.
        """
        with self._reading() as session:
            known = patient_row(session, patient).id
            query = select(PrescriptionTableRow).where(PrescriptionTableRow.patient == known)
            rows = session.scalars(query.order_by(PrescriptionTableRow.id.desc()))
            return tuple(value_of(PrescriptionRow, row) for row in rows)

    def add_session(self, therapy: TherapySession) -> TherapySession:
        """Add a sealed therapy session; its id is given here. A file that is there already is given back.

        Raises:
            Refused: The digest or path is not one, or patient or take is unknown.
        """
        path = relative(therapy.path)
        with self._writing() as session:
            query = select(TherapySessionRow).where(TherapySessionRow.sha256 == therapy.sha256)
            known = session.scalar(query)
            if known is not None:
                return value_of(TherapySession, known)
            given = short_id(therapy.sha256, lambda text: session.get(TherapySessionRow, text) is not None)
            row = TherapySessionRow(
                given,
                patient_row(session, therapy.patient).id if therapy.patient else None,
                take_row(session, therapy.take).id if therapy.take else None,
                therapy.sha256,
                path,
                therapy.mode,
                therapy.started_utc_ns,
            )
            taken = session.scalar(select(TherapySessionRow.id).where(TherapySessionRow.path == path))
            refuse_path(taken, path)
            session.add(row)
            return value_of(TherapySession, row)

    def session(self, therapy: str) -> TherapySession:
        """A therapy session by id, digest or unique beginning of it.

        Raises:
            Refused: No session has it.
        """
        with self._reading() as session:
            row = by_id(session, TherapySessionRow, therapy, "session", "give the path of its file")
            return value_of(TherapySession, row)

    def sessions(self, patient: str = "") -> tuple[TherapySession, ...]:
        """Therapy sessions, newest first; of one patient where named.

        Raises:
            Refused: No patient has that pseudonym.
        """
        with self._reading() as session:
            query = select(TherapySessionRow).order_by(TherapySessionRow.started_utc_ns.desc())
            if patient:
                query = query.where(TherapySessionRow.patient == patient_row(session, patient).id)
            return values_of(session, TherapySession, query)

    def find_sessions(self, start: int, count: int) -> tuple[tuple[TherapySession, ...], int]:
        """Therapy sessions of everybody, newest first: a part of them, and how many there are in all."""
        row = TherapySessionRow
        query = select(row).order_by(row.started_utc_ns.desc()).offset(start).limit(count)
        with self._reading() as session:
            total = session.scalar(select(func.count()).select_from(row)) or 0
            return values_of(session, TherapySession, query), total
