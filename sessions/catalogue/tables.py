"""The tables of the catalogue, typed. Migrations bring a file to this shape; nothing else makes tables."""

from __future__ import annotations

from sqlalchemy import BigInteger, ForeignKey, Index, MetaData, String, Text, event
from sqlalchemy.orm import DeclarativeBase, Mapped, MappedAsDataclass, mapped_column

from sessions.catalogue.search import CODE_POINTS, sorted_name, sought_text
from sessions.catalogue.texts import check_texts

NAMES = {
    "ix": "ix_%(column_0_label)s",
    "uq": "uq_%(table_name)s_%(column_0_name)s",
    "fk": "fk_%(table_name)s_%(column_0_name)s",
    "pk": "pk_%(table_name)s",
}


class Table(MappedAsDataclass, DeclarativeBase):
    """Root of all tables."""

    metadata = MetaData(naming_convention=NAMES)


class UserRow(Table):
    """People who may sign in."""

    __tablename__ = "users"
    id: Mapped[int] = mapped_column(primary_key=True, init=False)
    name: Mapped[str] = mapped_column(String(120), unique=True)
    role: Mapped[str] = mapped_column(String(20))
    password_hash: Mapped[str] = mapped_column(Text)
    active: Mapped[bool]
    created_utc_ns: Mapped[int] = mapped_column(BigInteger)


class PatientRow(Table):
    """Patients; the only table with their names."""

    __tablename__ = "patients"
    __table_args__ = (Index("ix_patients_archived_sorted_name", "archived", "sorted_name", "number"),)
    number: Mapped[int] = mapped_column(primary_key=True, init=False)
    id: Mapped[str] = mapped_column(String(20), unique=True)
    given_name: Mapped[str] = mapped_column(String(120))
    family_name: Mapped[str] = mapped_column(String(120))
    birth_date: Mapped[str] = mapped_column(String(10))
    side: Mapped[str] = mapped_column(String(5))
    hand_length_m: Mapped[float]
    impairment: Mapped[str] = mapped_column(Text)
    archived: Mapped[bool]
    created_utc_ns: Mapped[int] = mapped_column(BigInteger)
    version: Mapped[int]
    sorted_name: Mapped[str] = mapped_column(
        Text().with_variant(Text(collation=CODE_POINTS), "postgresql"), init=False, default=""
    )
    sought: Mapped[str] = mapped_column(Text, init=False, default="")


class ExerciseRow(Table):
    """The library of exercises."""

    __tablename__ = "exercises"
    name: Mapped[str] = mapped_column(String(120), primary_key=True)
    description: Mapped[str] = mapped_column(Text)


class TakeRow(Table):
    """Recorded demonstrations."""

    __tablename__ = "takes"
    id: Mapped[str] = mapped_column(String(64), primary_key=True)
    sha256: Mapped[str] = mapped_column(String(64), unique=True)
    path: Mapped[str] = mapped_column(Text, unique=True)
    side: Mapped[str] = mapped_column(String(5))
    exercise: Mapped[str] = mapped_column(String(120))
    source: Mapped[str] = mapped_column(String(60))
    duration_s: Mapped[float]
    subject_id: Mapped[str] = mapped_column(String(60), index=True)
    parent: Mapped[str | None] = mapped_column(ForeignKey("takes.id"), index=True)
    author: Mapped[str] = mapped_column(String(120))
    reason: Mapped[str] = mapped_column(Text)
    retouch: Mapped[str] = mapped_column(Text)
    created_utc_ns: Mapped[int] = mapped_column(BigInteger)


class ApprovalRow(Table):
    """Approvals, the last one of a take holds."""

    __tablename__ = "approvals"
    id: Mapped[int] = mapped_column(primary_key=True, init=False)
    take: Mapped[str] = mapped_column(ForeignKey("takes.id"), index=True)
    by: Mapped[str] = mapped_column(String(120))
    utc_ns: Mapped[int] = mapped_column(BigInteger)
    digest: Mapped[str] = mapped_column(String(64))


class PrescriptionTableRow(Table):
    """What was ordered."""

    __tablename__ = "prescriptions"
    id: Mapped[int] = mapped_column(primary_key=True, init=False)
    patient: Mapped[str] = mapped_column(ForeignKey("patients.id"), index=True)
    take: Mapped[str] = mapped_column(ForeignKey("takes.id"), index=True)
    mode: Mapped[str] = mapped_column(String(20))
    speed: Mapped[float]
    repetitions: Mapped[int]
    stiffness_multiple: Mapped[float]
    limits: Mapped[str] = mapped_column(Text)
    content: Mapped[str] = mapped_column(Text)
    by: Mapped[str] = mapped_column(String(120))
    created_utc_ns: Mapped[int] = mapped_column(BigInteger)


class TherapySessionRow(Table):
    """Runs on the robot."""

    __tablename__ = "therapy_sessions"
    id: Mapped[str] = mapped_column(String(64), primary_key=True)
    patient: Mapped[str | None] = mapped_column(ForeignKey("patients.id"), index=True)
    take: Mapped[str | None] = mapped_column(ForeignKey("takes.id"), index=True)
    sha256: Mapped[str] = mapped_column(String(64), unique=True)
    path: Mapped[str] = mapped_column(Text, unique=True)
    mode: Mapped[str] = mapped_column(String(20))
    started_utc_ns: Mapped[int] = mapped_column(BigInteger, index=True)


class CameraCalibrationRow(Table):
    """Calibrations of cameras; a version is never changed."""

    __tablename__ = "camera_calibrations"
    id: Mapped[int] = mapped_column(primary_key=True, init=False)
    digest: Mapped[str] = mapped_column(String(64), unique=True)
    camera: Mapped[str] = mapped_column(String(200), index=True)
    verdict: Mapped[str] = mapped_column(String(20))
    content: Mapped[str] = mapped_column(Text)
    created_utc_ns: Mapped[int] = mapped_column(BigInteger)


class HandRow(Table):
    """Calibrated hands of patients and therapists; a version is never changed."""

    __tablename__ = "hands"
    id: Mapped[int] = mapped_column(primary_key=True, init=False)
    person: Mapped[str] = mapped_column(String(60), index=True)
    side: Mapped[str] = mapped_column(String(5))
    protocol: Mapped[str] = mapped_column(String(120))
    content: Mapped[str] = mapped_column(Text)
    created_utc_ns: Mapped[int] = mapped_column(BigInteger)


class ClinicalRecordRow(Table):
    """What therapy must know of a patient's hand; a version is never changed."""

    __tablename__ = "clinical_records"
    id: Mapped[int] = mapped_column(primary_key=True, init=False)
    patient: Mapped[str] = mapped_column(ForeignKey("patients.id"), index=True)
    diagnosis: Mapped[str] = mapped_column(String(60))
    event_date: Mapped[str] = mapped_column(String(10))
    mas: Mapped[str] = mapped_column(String(2))
    insensate: Mapped[bool]
    unaware: Mapped[bool]
    rheumatoid: Mapped[bool]
    crps: Mapped[bool]
    hyperextension_allowed: Mapped[bool]
    bones_m: Mapped[str] = mapped_column(Text)
    by: Mapped[str] = mapped_column(String(120))
    created_utc_ns: Mapped[int] = mapped_column(BigInteger)


class ModeUnlockRow(Table):
    """Modes that a therapist unlocked before their date; the newest of a mode counts."""

    __tablename__ = "mode_unlocks"
    id: Mapped[int] = mapped_column(primary_key=True, init=False)
    patient: Mapped[str] = mapped_column(ForeignKey("patients.id"), index=True)
    mode: Mapped[str] = mapped_column(String(20))
    diagnosis: Mapped[str] = mapped_column(String(60))
    event_date: Mapped[str] = mapped_column(String(10))
    unlocked: Mapped[bool]
    reason: Mapped[str] = mapped_column(Text)
    by: Mapped[str] = mapped_column(String(120))
    created_utc_ns: Mapped[int] = mapped_column(BigInteger)


class DayLimitsRow(Table):
    """Limits measured on a patient; a version is never changed."""

    __tablename__ = "day_limits"
    id: Mapped[int] = mapped_column(primary_key=True, init=False)
    patient: Mapped[str] = mapped_column(ForeignKey("patients.id"), index=True)
    side: Mapped[str] = mapped_column(String(5))
    device: Mapped[str] = mapped_column(String(120))
    wrist_rad: Mapped[float]
    content: Mapped[str] = mapped_column(Text)
    measured_utc_ns: Mapped[int] = mapped_column(BigInteger)
    expires_utc_ns: Mapped[int] = mapped_column(BigInteger)
    by: Mapped[str] = mapped_column(String(120))


class LimitChangeRow(Table):
    """Limits of single joints that a person set; a version is never changed."""

    __tablename__ = "limit_changes"
    id: Mapped[int] = mapped_column(primary_key=True, init=False)
    patient: Mapped[str] = mapped_column(ForeignKey("patients.id"), index=True)
    device: Mapped[str] = mapped_column(String(120))
    joint: Mapped[str] = mapped_column(String(40))
    limit: Mapped[str] = mapped_column(String(30))
    value: Mapped[float]
    expires_utc_ns: Mapped[int] = mapped_column(BigInteger)
    reason: Mapped[str] = mapped_column(Text)
    by: Mapped[str] = mapped_column(String(120))
    created_utc_ns: Mapped[int] = mapped_column(BigInteger)


class AssistanceMemoryRow(Table):
    """Assistance that sessions ended with; a version is never changed."""

    __tablename__ = "assistance_memories"
    id: Mapped[int] = mapped_column(primary_key=True, init=False)
    patient: Mapped[str] = mapped_column(ForeignKey("patients.id"), index=True)
    exercise: Mapped[str] = mapped_column(String(120))
    device: Mapped[str] = mapped_column(String(120))
    content: Mapped[str] = mapped_column(Text)
    session: Mapped[str] = mapped_column(ForeignKey("therapy_sessions.id"))
    created_utc_ns: Mapped[int] = mapped_column(BigInteger)


class FitCheckRow(Table):
    """Fit checks; a version is never changed."""

    __tablename__ = "fit_checks"
    id: Mapped[int] = mapped_column(primary_key=True, init=False)
    patient: Mapped[str] = mapped_column(ForeignKey("patients.id"), index=True)
    side: Mapped[str] = mapped_column(String(5))
    device: Mapped[str] = mapped_column(String(120))
    content: Mapped[str] = mapped_column(Text)
    verdict: Mapped[str] = mapped_column(Text)
    session: Mapped[str] = mapped_column(ForeignKey("therapy_sessions.id"))
    by: Mapped[str] = mapped_column(String(120))
    created_utc_ns: Mapped[int] = mapped_column(BigInteger)


class AuditTableRow(Table):
    """The hash chain of what was done."""

    __tablename__ = "audit"
    seq: Mapped[int] = mapped_column(primary_key=True, autoincrement=False)
    utc_ns: Mapped[int] = mapped_column(BigInteger)
    actor: Mapped[str] = mapped_column(String(120))
    verb: Mapped[str] = mapped_column(String(60))
    subject: Mapped[str] = mapped_column(String(120), index=True)
    detail: Mapped[str] = mapped_column(Text)
    previous_hash: Mapped[str] = mapped_column(String(64))
    hash: Mapped[str] = mapped_column(String(64))


def _keep_findable(_mapper: object, _connection: object, row: PatientRow) -> None:
    """What lists and searches read follows the names, whoever writes them."""
    row.sorted_name = sorted_name(row.given_name, row.family_name)
    row.sought = sought_text(row.given_name, row.family_name, row.birth_date, row.id)


for _when in ("before_insert", "before_update"):
    event.listen(PatientRow, _when, _keep_findable)
    event.listen(Table, _when, check_texts, propagate=True)
