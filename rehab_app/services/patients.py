"""Patients of the clinic."""

from __future__ import annotations

from datetime import UTC, datetime

from rehab_app.access import Account, require
from rehab_app.errors import Refused
from rehab_app.services.audit import Audit
from sessions.catalogue import Catalogue, Patient
from sessions.records import SIDES, Side

LONGEST_NAME = 80


class Patients:
    """Patients; files know them by pseudonym only.

    Args:
        catalogue: The clinic's catalogue.
        audit: Where additions are noted.
    """

    def __init__(self, catalogue: Catalogue, audit: Audit) -> None:
        self._catalogue = catalogue
        self._audit = audit

    def list(self) -> tuple[Patient, ...]:
        """Patients that are not archived."""
        return self._catalogue.patients()

    def get(self, patient_id: str) -> Patient:
        """The patient of that pseudonym.

        Raises:
            Refused: There is none.
        """
        return self._catalogue.patient(patient_id)

    def add(
        self,
        actor: Account,
        *,
        given_name: str,
        family_name: str,
        birth_date: str,
        side: str,
        hand_length_m: float = 0.189,
        impairment: str = "",
    ) -> Patient:
        """Add a patient; the pseudonym is given by the catalogue.

        Args:
            actor: Who adds (verb "prescribe").
            given_name: Given name.
            family_name: Family name.
            birth_date: ISO date, 1950-12-31.
            side: Side of the affected hand.
            hand_length_m: Wrist crease to middle fingertip, 0.10 to 0.26 m.
            impairment: A note.

        Raises:
            Refused: The actor may not, or a value is out of bounds.
        """
        require(actor, "prescribe")
        chosen = side_named(side)
        if not 0.10 <= hand_length_m <= 0.26:
            raise Refused(
                "hand length",
                f"{hand_length_m:g} m",
                "0.10 to 0.26 m",
                "measure wrist crease to middle fingertip",
            )
        for part, name in (("given name", given_name), ("family name", family_name)):
            _check_name(part, name.strip())
        patient = Patient(  # refuses what is no date, before it is compared with today
            given_name=given_name.strip(),
            family_name=family_name.strip(),
            birth_date=birth_date.strip(),
            side=chosen,
            hand_length_m=hand_length_m,
            impairment=impairment.strip(),
        )
        if patient.birth_date > datetime.now(UTC).date().isoformat():
            raise Refused("birth date", patient.birth_date, "today or before", "correct it")
        patient = self._catalogue.add_patient(patient)
        self._audit.note(actor, "add patient", patient.id)
        return patient


def _check_name(part: str, name: str) -> None:
    """Refuse a name that no screen can show.

    Raises:
        Refused: It is too long, or holds characters that do not print.
    """
    if len(name) > LONGEST_NAME or not (name.isprintable() or not name):
        value = f"{len(name)} characters" if name.isprintable() else "not printable"
        raise Refused(
            f"patient's {part}", value, f"at most {LONGEST_NAME} printable characters", "shorten it"
        )


def side_named(name: str) -> Side:
    """The side of that name.

    Raises:
        Refused: It is neither left nor right.
    """
    for side in SIDES:
        if side == name:
            return side
    raise Refused("side", repr(name), "left or right", "name the side of the hand")
