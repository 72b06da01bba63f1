"""Verbs of the clinic's daily writing: entries about patients, settings, cached metrics."""

from __future__ import annotations

from collections.abc import Iterable

from sqlalchemy import select
from sqlalchemy.orm import Session

from sessions.catalogue.clinic_records import PatientEntry, Setting
from sessions.catalogue.clinic_tables import MetricSetRow, PatientEntryRow, SettingRow
from sessions.catalogue.ledger import Ledger
from sessions.catalogue.rows import by_id, patient_row, value_of
from sessions.catalogue.tables import TherapySessionRow
from sessions.catalogue.versions import check_newest


class Book(Ledger):
    """Entries, settings, metrics. Lists: newest first."""

    def add_entry(self, entry: PatientEntry) -> PatientEntry:
        """Write an entry; its number and time are given here.

        Raises:
            Refused: Patient or session is unknown.
        """
        with self._writing() as session:
            return self._entered(session, entry)

    def add_version(self, entry: PatientEntry, since: int) -> PatientEntry:
        """Write an entry that replaces the one before, such as a plan; its number and time are given here.

        Args:
            entry: What is written.
            since: Number of the newest entry of this kind and patient as the writer had read it, 0 where
                there was none.

        Raises:
            Refused: Patient or session is unknown, or somebody else wrote one since.
        """
        with self._writing() as session:
            of_patient = PatientEntryRow.patient == entry.patient, PatientEntryRow.kind == entry.kind
            thing = f"{entry.kind} of {entry.patient}"
            check_newest(session, PatientEntryRow, *of_patient, since=since, thing=thing)
            return self._entered(session, entry)

    def _entered(self, session: Session, entry: PatientEntry) -> PatientEntry:
        held: str | None = None
        if entry.session:
            known = by_id(session, TherapySessionRow, entry.session, "session", "check its id")
            held = known.id
        row = PatientEntryRow(
            patient_row(session, entry.patient).id,
            entry.kind,
            entry.topic,
            held,
            entry.content,
            entry.by,
            self._clock_ns(),
        )
        session.add(row)
        session.flush()
        return value_of(PatientEntry, row)

    def entries(
        self, patient: str, kinds: Iterable[str], topic: str = "", session: str = "", limit: int = 500
    ) -> tuple[PatientEntry, ...]:
        """What was written about a patient, newest first.

        Args:
            patient: Pseudonym.
            kinds: Which kinds.
            topic: Only of this topic, empty for all.
            session: Only of this therapy session, empty for all.
            limit: At most so many.

        Raises:
            Refused: The patient is unknown.
        """
        with self._reading() as reading:
            query = select(PatientEntryRow).where(
                PatientEntryRow.patient == patient_row(reading, patient).id,
                PatientEntryRow.kind.in_(tuple(kinds)),
            )
            if topic:
                query = query.where(PatientEntryRow.topic == topic)
            if session:
                query = query.where(PatientEntryRow.session == session)
            rows = reading.scalars(query.order_by(PatientEntryRow.id.desc()).limit(limit))
            return tuple(value_of(PatientEntry, row) for row in rows)

    def set(self, setting: Setting) -> Setting:
        """Write a version of a setting; its number and time are given here."""
        with self._writing() as session:
            row = SettingRow(setting.key, setting.content, setting.by, self._clock_ns())
            session.add(row)
            session.flush()
            return value_of(Setting, row)

    def setting(self, key: str) -> Setting | None:
        """The newest version of a setting, None where nobody set it."""
        with self._reading() as session:
            query = select(SettingRow).where(SettingRow.key == key).order_by(SettingRow.id.desc()).limit(1)
            row = session.scalar(query)
            return None if row is None else value_of(Setting, row)

    def keep_metrics(self, sha256: str, version: str, content: str) -> None:
        """Keep the numbers of a sealed file; what is kept already stays."""
        with self._writing() as session:
            if session.get(MetricSetRow, (sha256, version)) is None:
                session.add(MetricSetRow(sha256, version, content, self._clock_ns()))

    def kept_metrics(self, sha256s: Iterable[str], version: str) -> dict[str, str]:
        """Kept numbers of sealed files by digest; what is not kept is left out."""
        wanted = tuple(sha256s)
        found: dict[str, str] = {}
        with self._reading() as session:
            for start in range(0, len(wanted), 500):
                query = select(MetricSetRow).where(
                    MetricSetRow.version == version, MetricSetRow.sha256.in_(wanted[start : start + 500])
                )
                found |= {row.sha256: row.content for row in session.scalars(query)}
        return found
