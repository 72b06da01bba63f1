"""Verbs about what therapy must know of a patient: versions are added, the newest counts, none is changed."""

from __future__ import annotations

from sqlalchemy import select
from sqlalchemy.orm import Session

from sessions.catalogue.clinical_records import (
    AssistanceMemory,
    ClinicalRecord,
    DayLimits,
    FitCheck,
    LimitChange,
    LimitsRead,
    ModeUnlock,
)
from sessions.catalogue.ledger import Ledger
from sessions.catalogue.rows import by_id, patient_row, value_of
from sessions.catalogue.tables import (
    AssistanceMemoryRow,
    ClinicalRecordRow,
    DayLimitsRow,
    FitCheckRow,
    LimitChangeRow,
    ModeUnlockRow,
    TherapySessionRow,
)
from sessions.catalogue.versions import check_newest


class Clinical(Ledger):
    """Clinical records, unlocked modes, limits, fit checks and remembered assistance. Lists: newest first."""

    def add_clinical_record(self, record: ClinicalRecord, since: int | None = None) -> ClinicalRecord:
        """Add a version; its number and time are given here.

        Args:
            record: What is known.
            since: Version that the writer had read, 0 where there was none; None if it does not matter.

        Raises:
            Refused: The patient is unknown, or somebody else stated a version since.
        """
        with self._writing() as session:
            _check_record(session, record.patient, since)
            row = ClinicalRecordRow(
                patient_row(session, record.patient).id,
                record.diagnosis,
                record.event_date,
                record.mas,
                record.insensate,
                record.unaware,
                record.rheumatoid,
                record.crps,
                record.hyperextension_allowed,
                record.bones_m,
                record.by,
                self._clock_ns(),
            )
            session.add(row)
            session.flush()
            return value_of(ClinicalRecord, row)

    def clinical_records(self, patient: str) -> tuple[ClinicalRecord, ...]:
        """Every version of a patient's record.

        Raises:
            Refused: The patient is unknown.
        """
        with self._reading() as session:
            known = patient_row(session, patient).id
            query = select(ClinicalRecordRow).where(ClinicalRecordRow.patient == known)
            rows = session.scalars(query.order_by(ClinicalRecordRow.id.desc()))
            return tuple(value_of(ClinicalRecord, row) for row in rows)

    def add_mode_unlock(self, unlock: ModeUnlock) -> ModeUnlock:
        """Add a decision about a locked mode; its number and time are given here.

        Raises:
            Refused: The patient is unknown.
        """
        with self._writing() as session:
            row = ModeUnlockRow(
                patient_row(session, unlock.patient).id,
                unlock.mode,
                unlock.diagnosis,
                unlock.event_date,
                unlock.unlocked,
                unlock.reason,
                unlock.by,
                self._clock_ns(),
            )
            session.add(row)
            session.flush()
            return value_of(ModeUnlock, row)

    def mode_unlocks(self, patient: str) -> tuple[ModeUnlock, ...]:
        """Every decision about a patient's locked modes.

        Raises:
            Refused: The patient is unknown.
        """
        with self._reading() as session:
            known = patient_row(session, patient).id
            query = select(ModeUnlockRow).where(ModeUnlockRow.patient == known)
            rows = session.scalars(query.order_by(ModeUnlockRow.id.desc()))
            return tuple(value_of(ModeUnlock, row) for row in rows)

    def add_day_limits(self, limits: DayLimits) -> DayLimits:
        """Add measured limits; their number is given here.

        Raises:
            Refused: The patient is unknown.
        """
        with self._writing() as session:
            row = DayLimitsRow(
                patient_row(session, limits.patient).id,
                limits.side,
                limits.device,
                limits.wrist_rad,
                limits.content,
                limits.measured_utc_ns,
                limits.expires_utc_ns,
                limits.by,
            )
            session.add(row)
            session.flush()
            return value_of(DayLimits, row)

    def day_limits(self, patient: str, device: str) -> tuple[DayLimits, ...]:
        """Everything measured on a patient in a device, old and new.

        Raises:
            Refused: The patient is unknown.
        """
        with self._reading() as session:
            known = patient_row(session, patient).id
            query = select(DayLimitsRow).where(DayLimitsRow.patient == known, DayLimitsRow.device == device)
            rows = session.scalars(query.order_by(DayLimitsRow.id.desc()))
            return tuple(value_of(DayLimits, row) for row in rows)

    def add_limit_change(self, change: LimitChange) -> LimitChange:
        """Add a limit that a person set; its number and time are given here.

        Raises:
            Refused: The patient is unknown.
        """
        return self.add_limit_changes((change,))[0]

    def add_limit_changes(
        self, changes: tuple[LimitChange, ...], since: LimitsRead | None = None
    ) -> tuple[LimitChange, ...]:
        """Add limits that a person set on one patient in one device, all or none.

        Args:
            changes: What was set.
            since: What the writer had read; None if it does not matter.

        Raises:
            Refused: The patient is unknown, or somebody else set limits or stated the record since.
        """
        with self._writing() as session:
            rows: list[LimitChangeRow] = []
            for change in changes:
                patient = patient_row(session, change.patient).id
                if since is not None and not rows:
                    _check_limits(session, change, since)
                rows.append(_limit_row(patient, change, self._clock_ns()))
                session.add(rows[-1])
            session.flush()
            return tuple(value_of(LimitChange, row) for row in rows)

    def limit_changes(self, patient: str, device: str) -> tuple[LimitChange, ...]:
        """Every limit that was set for a patient in a device, expired ones among them.

        Raises:
            Refused: The patient is unknown.
        """
        with self._reading() as session:
            known = patient_row(session, patient).id
            query = select(LimitChangeRow).where(
                LimitChangeRow.patient == known, LimitChangeRow.device == device
            )
            rows = session.scalars(query.order_by(LimitChangeRow.id.desc()))
            return tuple(value_of(LimitChange, row) for row in rows)

    def add_assistance(self, memory: AssistanceMemory) -> AssistanceMemory:
        """Remember the assistance of a session; its number and time are given here.

        Raises:
            Refused: Patient or session is unknown.
        """
        with self._writing() as session:
            known = by_id(session, TherapySessionRow, memory.session, "session", "give the path of its file")
            row = AssistanceMemoryRow(
                patient_row(session, memory.patient).id,
                memory.exercise,
                memory.device,
                memory.content,
                known.id,
                self._clock_ns(),
            )
            session.add(row)
            session.flush()
            return value_of(AssistanceMemory, row)

    def assistance(self, patient: str, exercise: str, device: str) -> AssistanceMemory | None:
        """What the last session of this patient, exercise and device ended with, None before the first.

        Raises:
            Refused: The patient is unknown.
        """
        with self._reading() as session:
            query = select(AssistanceMemoryRow).where(
                AssistanceMemoryRow.patient == patient_row(session, patient).id,
                AssistanceMemoryRow.exercise == exercise,
                AssistanceMemoryRow.device == device,
            )
            row = session.scalar(query.order_by(AssistanceMemoryRow.id.desc()).limit(1))
            return None if row is None else value_of(AssistanceMemory, row)

    def add_fit_check(self, check: FitCheck) -> FitCheck:
        """Keep a fit check; its number and time are given here.

        Raises:
            Refused: Patient or session is unknown.
        """
        with self._writing() as session:
            known = by_id(session, TherapySessionRow, check.session, "session", "give the path of its file")
            row = FitCheckRow(
                patient_row(session, check.patient).id,
                check.side,
                check.device,
                check.content,
                check.verdict,
                known.id,
                check.by,
                self._clock_ns(),
            )
            session.add(row)
            session.flush()
            return value_of(FitCheck, row)

    def fit_checks(self, patient: str, device: str) -> tuple[FitCheck, ...]:
        """Every fit check of a patient in a device.

        Raises:
            Refused: The patient is unknown.
        """
        with self._reading() as session:
            known = patient_row(session, patient).id
            query = select(FitCheckRow).where(FitCheckRow.patient == known, FitCheckRow.device == device)
            rows = session.scalars(query.order_by(FitCheckRow.id.desc()))
            return tuple(value_of(FitCheck, row) for row in rows)


def _check_record(session: Session, patient: str, since: int | None) -> None:
    thing = f"clinical record of {patient}"
    check_newest(session, ClinicalRecordRow, ClinicalRecordRow.patient == patient, since=since, thing=thing)


def _check_limits(session: Session, change: LimitChange, since: LimitsRead) -> None:
    of_device = LimitChangeRow.patient == change.patient, LimitChangeRow.device == change.device
    thing = f"limits of {change.patient}"
    check_newest(session, LimitChangeRow, *of_device, since=since.change, thing=thing)
    _check_record(session, change.patient, since.record)


def _limit_row(patient: str, change: LimitChange, now_ns: int) -> LimitChangeRow:
    return LimitChangeRow(
        patient,
        change.device,
        change.joint,
        change.limit,
        change.value,
        change.expires_utc_ns,
        change.reason,
        change.by,
        now_ns,
    )
