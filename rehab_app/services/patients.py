"""Patients of the clinic."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from datetime import UTC, date, datetime

from rehab_app.access import Account, require
from rehab_app.errors import Refused
from rehab_app.services.audit import Audit
from rehab_app.services.own_patients import OwnPatients
from rehab_app.services.plain_text import many_lines, one_line
from sessions.catalogue import AuditRow, Catalogue, Patient, Take, TherapySession
from sessions.records import SIDES, Side

LONGEST_NAME = 80
LONGEST_NOTE = 2000
ON_A_PAGE = 50
FOR_CHOICE = 20
"""How many a list offers for choice before it is searched instead."""
HAND_LENGTH_M = (0.10, 0.26)
_OLDEST_YEARS = 130
_AUDIT_ROWS = 500


@dataclass(frozen=True, slots=True)
class Found:
    """A page of patients that were looked for.

    Attributes:
        patients: Those of this page.
        total: How many there are on all pages.
        page: Number of this page, from 1.
        pages: Number of pages, at least 1.
    """

    patients: tuple[Patient, ...]
    total: int
    page: int
    pages: int


class Patients:
    """Patients; files know them by pseudonym only.

    Args:
        catalogue: The clinic's catalogue.
        audit: Where additions and changes are noted.
    """

    def __init__(self, catalogue: Catalogue, audit: Audit) -> None:
        self._catalogue = catalogue
        self._audit = audit
        self._own_patients = OwnPatients(catalogue, audit)

    def list(self) -> tuple[Patient, ...]:
        """Patients that are not archived."""
        return self._catalogue.patients()

    def search(self, typed: str = "", *, archived: bool = False, order: str = "name", page: int = 1) -> Found:
        """Patients by words of their name, birth date or pseudonym; accents and case do not matter.

        Args:
            typed: Words, all of which must be found; empty for everybody.
            archived: Among the archived ones, else among the others.
            order: "name", "birth", "side" or "added"; a leading "-" turns it round.
            page: Number of the page of 50, from 1; the last one where there are fewer.

        Raises:
            Refused: The words are too long or the order is unknown.
        """
        words = one_line("search", typed, 2 * LONGEST_NAME)
        start = ON_A_PAGE * max(page - 1, 0)
        rows, total = self._catalogue.find_patients(
            words, archived=archived, order=order, start=start, count=ON_A_PAGE
        )
        pages = max(1, math.ceil(total / ON_A_PAGE))
        if page > pages:
            return self.search(typed, archived=archived, order=order, page=pages)
        return Found(rows, total, max(page, 1), pages)

    def choice(self, typed: str = "", kept: str = "") -> Found:
        """A few patients for a list to choose from, at most 20 and the one that is kept.

        Args:
            typed: Words as of ``search``; empty for those lately treated, prescribed for or added.
            kept: Pseudonym of a patient who is in the list in any case: the one chosen already.

        Raises:
            Refused: The words are too long.
        """
        words = one_line("search", typed, 2 * LONGEST_NAME)
        rows, total = (
            self._catalogue.find_patients(words, count=FOR_CHOICE)
            if words
            else self._catalogue.recent_patients(FOR_CHOICE)
        )
        if kept and all(one.id != kept for one in rows):
            rows = (*self._catalogue.patients_named((kept,)), *rows)
        return Found(rows, total, 1, 1)

    def namesakes(self, given_name: str, family_name: str, birth_date: str) -> tuple[Patient, ...]:
        """Patients of the same name or the same birth date, whom the new one could be mistaken for."""
        return self._catalogue.namesakes(given_name, family_name, birth_date.strip())

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
        check_hand_length(hand_length_m)
        patient = checked(
            Patient(  # refuses what is no date, before it is compared with today
                given_name=given_name,
                family_name=family_name,
                birth_date=birth_date.strip(),
                side=chosen,
                hand_length_m=hand_length_m,
                impairment=impairment,
            )
        )
        patient = self._catalogue.add_patient(patient)
        self._audit.note(actor, "add patient", patient.id)
        return patient

    def change(self, actor: Account, patient: Patient) -> Patient:
        """Write what identifies a patient and the hand; the record must be the version that was read.

        Args:
            actor: Who changes (verb "prescribe").
            patient: The whole record; its version says from which one it was made.

        Raises:
            Refused: The actor may not, a value is out of bounds, or somebody else changed it meanwhile.
        """
        require(actor, "prescribe")
        check_hand_length(patient.hand_length_m)
        before = self._catalogue.patient(patient.id)
        wanted = replace(checked(patient), archived=before.archived)
        if replace(wanted, created_utc_ns=before.created_utc_ns, version=before.version) == before:
            return before
        kept = self._catalogue.change_patient(wanted)
        names = ("given_name", "family_name", "birth_date", "side", "hand_length_m", "impairment")
        changed = [name for name in names if getattr(before, name) != getattr(kept, name)]
        self._audit.note(actor, "change patient", kept.id, f"version {kept.version}: {', '.join(changed)}")
        return kept

    def archive(self, actor: Account, patient_id: str) -> Patient:
        """Take a patient out of the lists; nothing is lost, but no screen shows this patient any more.

        Raises:
            Refused: The actor may not prescribe, or the patient is unknown.
        """
        return self._keep_archived(actor, patient_id, archived=True)

    def unarchive(self, actor: Account, patient_id: str) -> Patient:
        """Put a patient back into the lists.

        Raises:
            Refused: The actor may not prescribe, or the patient is unknown.
        """
        return self._keep_archived(actor, patient_id, archived=False)

    def last_change(self, patient_id: str) -> AuditRow | None:
        """Who changed the record last, and when; None where it is not among the newest rows of the audit."""
        rows = self._catalogue.audit(_AUDIT_ROWS)
        return next((row for row in rows if (row.verb, row.subject) == ("change patient", patient_id)), None)

    def takes(self, patient_id: str) -> tuple[Take, ...]:
        """Takes that were recorded of this patient's own hands, newest first."""
        return self._catalogue.takes_of(patient_id)

    def sessions(self, patient_id: str) -> tuple[TherapySession, ...]:
        """Sessions of this patient, newest first.

        Raises:
            Refused: The patient is unknown.
        """
        return self._catalogue.sessions(patient_id)

    def _keep_archived(self, actor: Account, patient_id: str, *, archived: bool) -> Patient:
        require(actor, "prescribe")
        patient = self._catalogue.patient(patient_id)
        if patient.archived == archived:
            return patient
        kept = self._catalogue.change_patient(replace(patient, archived=archived))
        self._audit.note(actor, "archive patient" if archived else "unarchive patient", patient_id)
        if archived:
            self._own_patients.release(patient_id, actor)
        return kept


def checked(patient: Patient) -> Patient:
    """The patient with trimmed texts in one form of Unicode.

    Raises:
        Refused: A name or the note is too long or cannot be shown, or nobody alive was born on that date.
    """
    today = datetime.now(UTC).astimezone().date()
    check_birth_date(patient.birth_date, today)
    return replace(
        patient,
        given_name=one_line("patient's given name", patient.given_name, LONGEST_NAME),
        family_name=one_line("patient's family name", patient.family_name, LONGEST_NAME),
        impairment=many_lines("impairment and precautions", patient.impairment, LONGEST_NOTE),
    )


def check_birth_date(birth_date: str, today: date) -> None:
    """Refuse a birth date, ISO or empty, that nobody alive can have.

    Raises:
        Refused: It lies in the future or too far back.
    """
    if birth_date > today.isoformat():
        raise Refused("birth date", birth_date, "today or before", "correct it")
    earliest = f"{today.year - _OLDEST_YEARS:04d}-01-01"
    if birth_date and birth_date < earliest:
        raise Refused("birth date", birth_date, f"{earliest} or later", "correct the year")


def check_hand_length(hand_length_m: float) -> None:
    """Refuse what is the length of no hand.

    Raises:
        Refused: It is not 0.10 to 0.26 m.
    """
    low, high = HAND_LENGTH_M
    if not low <= hand_length_m <= high:
        raise Refused(
            "hand length",
            f"{hand_length_m:g} m",
            f"{low:.2f} to {high:.2f} m",
            "measure wrist crease to middle fingertip",
        )


def side_named(name: str) -> Side:
    """The side of that name.

    Raises:
        Refused: It is neither left nor right.
    """
    for side in SIDES:
        if side == name:
            return side
    raise Refused("side", repr(name[:40]), "left or right", "name the side of the hand")
