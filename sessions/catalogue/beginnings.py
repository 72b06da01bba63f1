"""What a clinic has begun with: asked by pages that lead through the first steps."""

from __future__ import annotations

from dataclasses import dataclass

from sqlalchemy import select

from sessions.catalogue.ledger import Ledger
from sessions.catalogue.tables import PatientRow, TakeRow, TherapySessionRow


@dataclass(frozen=True, slots=True)
class Begun:
    """What there is at least one of.

    Attributes:
        patients: Patients, archived ones among them.
        takes: Recorded movements.
        sessions: Sessions of therapy.
    """

    patients: bool
    takes: bool
    sessions: bool


class Beginnings(Ledger):
    """Whether there is anything yet."""

    def begun(self) -> Begun:
        """What there is at least one of; costs the same however much there is."""
        with self._reading() as session:
            found = (
                session.scalar(select(kind.id).limit(1)) is not None
                for kind in (PatientRow, TakeRow, TherapySessionRow)
            )
            return Begun(*found)
