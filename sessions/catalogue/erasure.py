"""Everything the catalogue holds about one patient: read as a whole, and erased for good."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any

from sqlalchemy import Column, delete, func, select, text, update
from sqlalchemy.orm import Session

from sessions.catalogue.clinic_tables import MetricSetRow, PatientEntryRow, SettingRow
from sessions.catalogue.ledger import Ledger
from sessions.catalogue.rows import patient_row
from sessions.catalogue.tables import (
    ApprovalRow,
    HandRow,
    PatientRow,
    PrescriptionTableRow,
    Table,
    TakeRow,
    TherapySessionRow,
)

UNFINISHED = "erasure"
"""Key of the setting that lists the files of erased patients until they are deleted."""

OWN_PATIENT = "own-patient:"
"""Begins the key of a setting, with an account's number: JSON of whose screen it is, "" for nobody's."""


@dataclass(frozen=True, slots=True)
class Belongings:
    """What belongs to a patient.

    Attributes:
        patient: Pseudonym.
        created_utc_ns: When the patient was added; with the pseudonym it tells one patient from all others.
        sessions: Therapy sessions, as path and SHA-256.
        takes: Takes of the patient's own hand that nobody else's therapy uses, likewise.
        shared_takes: Ids of such takes that others' therapy uses.
    """

    patient: str
    created_utc_ns: int
    sessions: tuple[tuple[str, str], ...]
    takes: tuple[tuple[str, str], ...]
    shared_takes: tuple[str, ...]


class Erasure(Ledger):
    """Reads and erases patients."""

    def patient_rows(self, patient: str) -> dict[str, list[dict[str, Any]]]:
        """Every row about a patient by table, as column name and value; also hands and takes of the patient.

        Raises:
            Refused: The patient is unknown.
        """
        with self._reading() as session:
            known = patient_row(session, patient).id
            found: dict[str, list[dict[str, Any]]] = {}
            for name, columns in _owned().items():
                table = Table.metadata.tables[name]
                query = select(table).where(columns == known)
                found[name] = [dict(row) for row in session.execute(query).mappings()]
            return found

    def belongings(self, patient: str) -> Belongings:
        """Files that belong to a patient.

        Raises:
            Refused: The patient is unknown.
        """
        with self._reading() as session:
            return _belongings(session, patient_row(session, patient))

    def erase_patient(self, patient: str, remember: str, by: str) -> Belongings:
        """Erase every row about a patient; the pseudonym alone stays, so that it is never given again.

        Takes that others' therapy uses lose their link to the patient. Files are not touched.

        Args:
            patient: Pseudonym.
            remember: JSON of what is left to do, kept as the setting UNFINISHED in the same transaction.
            by: Who erases.

        Raises:
            Refused: The patient is unknown.
        """
        with self._writing() as session:
            if self._engine.dialect.name == "sqlite":
                session.execute(text("PRAGMA secure_delete = ON"))
            row = patient_row(session, patient)
            found = _belongings(session, row)
            _erase_rows(session, row.id, found)
            row.given_name = row.family_name = row.birth_date = row.impairment = ""
            row.hand_length_m, row.archived = 0.189, True
            row.version += 1
            session.add(SettingRow(UNFINISHED, remember, by, self._clock_ns()))
        self._forget_pages()
        return found

    def last_activity(self) -> dict[str, int]:
        """When something was last recorded or written, UTC in ns, by patient that has a name still."""
        with self._reading() as session:
            named = select(PatientRow.id, PatientRow.created_utc_ns).where(PatientRow.family_name != "")
            found: dict[str, int] = {row.id: row.created_utc_ns for row in session.execute(named)}
            for kind, at in (
                (TherapySessionRow, TherapySessionRow.started_utc_ns),
                (PatientEntryRow, PatientEntryRow.created_utc_ns),
            ):
                newest = select(kind.patient, func.max(at)).group_by(kind.patient)
                for one, when in session.execute(newest):
                    if one in found:
                        found[one] = max(found[one], when)
            return found

    def _forget_pages(self) -> None:
        """What was deleted also leaves the write-ahead log and the free pages."""
        if self._engine.dialect.name != "sqlite":
            return
        with self._engine.connect().execution_options(isolation_level="AUTOCOMMIT") as connection:
            connection.exec_driver_sql("PRAGMA wal_checkpoint(TRUNCATE)")


def _owned() -> dict[str, Column[Any]]:
    """The column of each table that names a patient, found by its reference: no table is forgotten."""
    owned: dict[str, Column[Any]] = {"patients": Table.metadata.tables["patients"].c.id}
    for table in Table.metadata.sorted_tables:
        for column in table.columns:
            if any(key.target_fullname == "patients.id" for key in column.foreign_keys):
                owned[table.name] = column
    owned["hands"] = Table.metadata.tables["hands"].c.person
    owned["takes"] = Table.metadata.tables["takes"].c.subject_id
    return owned


def _belongings(session: Session, row: PatientRow) -> Belongings:
    held = session.execute(
        select(TherapySessionRow.path, TherapySessionRow.sha256).where(TherapySessionRow.patient == row.id)
    )
    takes = list(session.scalars(select(TakeRow).where(TakeRow.subject_id == row.id)))
    shared = tuple(take.id for take in takes if _used_by_others(session, take.id, row.id))
    return Belongings(
        row.id,
        row.created_utc_ns,
        tuple((one.path, one.sha256) for one in held),
        tuple((take.path, take.sha256) for take in takes if take.id not in shared),
        shared,
    )


def _used_by_others(session: Session, take: str, patient: str) -> bool:
    """Whether therapy of somebody else stands on a take, or on one that was made of it."""
    for kind in (TherapySessionRow, PrescriptionTableRow):
        other = select(kind.id).where(kind.take == take, kind.patient.is_distinct_from(patient)).limit(1)
        if session.scalar(other) is not None:
            return True
    children = session.scalars(select(TakeRow.id).where(TakeRow.parent == take))
    return any(_used_by_others(session, child, patient) for child in children)


def _erase_rows(session: Session, patient: str, found: Belongings) -> None:
    digests = [sha256 for _, sha256 in (*found.sessions, *found.takes)]
    session.execute(delete(MetricSetRow).where(MetricSetRow.sha256.in_(digests)))
    tables = [
        (Table.metadata.tables[name], column)
        for name, column in _owned().items()
        if name not in ("patients", "takes", "therapy_sessions")
    ]
    for table, column in reversed(tables):
        session.execute(delete(table).where(column == patient))
    session.execute(delete(TherapySessionRow).where(TherapySessionRow.patient == patient))
    session.execute(delete(HandRow).where(HandRow.person == patient))
    gone = select(TakeRow.id).where(TakeRow.sha256.in_([sha256 for _, sha256 in found.takes]))
    ids = list(session.scalars(gone))
    session.execute(update(TakeRow).where(TakeRow.parent.in_(ids)).values(parent=None))
    session.execute(delete(ApprovalRow).where(ApprovalRow.take.in_(ids)))
    session.execute(update(TherapySessionRow).where(TherapySessionRow.take.in_(ids)).values(take=None))
    session.execute(delete(TakeRow).where(TakeRow.id.in_(ids)))
    session.execute(update(TakeRow).where(TakeRow.id.in_(found.shared_takes)).values(subject_id="erased"))
    # emptied, not deleted: without this version an older one, of another patient, would count again
    tie = SettingRow.key.startswith(OWN_PATIENT), SettingRow.content == json.dumps(patient)
    session.execute(update(SettingRow).where(*tie).values(content=json.dumps("")))
