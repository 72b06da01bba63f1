"""Tables of the clinic's stations and of the patients in therapy at them."""

from __future__ import annotations

from sqlalchemy import BigInteger, ForeignKey, String
from sqlalchemy.orm import Mapped, mapped_column

from sessions.catalogue.tables import Table


class StationRow(Table):
    """Machines that serve the clinic, as each said of itself last."""

    __tablename__ = "stations"
    name: Mapped[str] = mapped_column(String(63), primary_key=True)
    holder: Mapped[str] = mapped_column(String(32))
    version: Mapped[str] = mapped_column(String(60))
    offset_ns: Mapped[int] = mapped_column(BigInteger)
    uncertainty_ns: Mapped[int] = mapped_column(BigInteger)
    seen_utc_ns: Mapped[int] = mapped_column(BigInteger)


class PatientClaimRow(Table):
    """Patients in therapy, each at one station; a row whose time is over binds nobody."""

    __tablename__ = "patient_claims"
    patient: Mapped[str] = mapped_column(ForeignKey("patients.id"), primary_key=True)
    station: Mapped[str] = mapped_column(String(63))
    holder: Mapped[str] = mapped_column(String(32))
    since_utc_ns: Mapped[int] = mapped_column(BigInteger)
    until_utc_ns: Mapped[int] = mapped_column(BigInteger)
