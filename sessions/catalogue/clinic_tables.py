"""Tables of the clinic's daily writing: entries about patients, sign-ins, settings, cached metrics."""

from __future__ import annotations

from sqlalchemy import BigInteger, ForeignKey, Index, String, Text
from sqlalchemy.orm import Mapped, mapped_column

from sessions.catalogue.tables import Table


class PatientEntryRow(Table):
    """What is written about a patient; an entry is never changed, a newer one replaces it."""

    __tablename__ = "patient_entries"
    __table_args__ = (Index("ix_patient_entries_patient_kind", "patient", "kind"),)
    id: Mapped[int] = mapped_column(primary_key=True, init=False)
    patient: Mapped[str] = mapped_column(ForeignKey("patients.id"))
    kind: Mapped[str] = mapped_column(String(30))
    topic: Mapped[str] = mapped_column(String(60))
    session: Mapped[str | None] = mapped_column(ForeignKey("therapy_sessions.id"), index=True)
    content: Mapped[str] = mapped_column(Text)
    by: Mapped[str] = mapped_column(String(120))
    created_utc_ns: Mapped[int] = mapped_column(BigInteger)


class SignInRow(Table):
    """Sign-ins; the cookie carries a secret whose digest is the id."""

    __tablename__ = "sign_ins"
    id: Mapped[str] = mapped_column(String(64), primary_key=True)
    user: Mapped[str] = mapped_column(String(120), index=True)
    issued_utc_ns: Mapped[int] = mapped_column(BigInteger)
    seen_utc_ns: Mapped[int] = mapped_column(BigInteger)
    ended_utc_ns: Mapped[int] = mapped_column(BigInteger)


class SettingRow(Table):
    """Settings of the clinic; a version is never changed, the newest of a key counts."""

    __tablename__ = "settings"
    id: Mapped[int] = mapped_column(primary_key=True, init=False)
    key: Mapped[str] = mapped_column(String(60), index=True)
    content: Mapped[str] = mapped_column(Text)
    by: Mapped[str] = mapped_column(String(120))
    created_utc_ns: Mapped[int] = mapped_column(BigInteger)


class MetricSetRow(Table):
    """Numbers of a sealed file, by its digest and the version of the methods."""

    __tablename__ = "metric_sets"
    sha256: Mapped[str] = mapped_column(String(64), primary_key=True)
    version: Mapped[str] = mapped_column(String(64), primary_key=True)
    content: Mapped[str] = mapped_column(Text)
    created_utc_ns: Mapped[int] = mapped_column(BigInteger)
