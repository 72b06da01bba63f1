"""Table of what stations delivered."""

from __future__ import annotations

from sqlalchemy import BigInteger, String
from sqlalchemy.orm import Mapped, mapped_column

from sessions.catalogue.tables import Table


class DeliveryRow(Table):
    """Numbers of deliveries that arrived; written in the transaction of what they brought."""

    __tablename__ = "deliveries"
    id: Mapped[str] = mapped_column(String(32), primary_key=True)
    utc_ns: Mapped[int] = mapped_column(BigInteger)
