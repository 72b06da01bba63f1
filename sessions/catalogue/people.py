"""Verbs about people: those who sign in, and patients."""

from __future__ import annotations

from itertools import islice
from typing import Any

from sqlalchemy import ColumnElement, func, or_, select

from sessions.catalogue.ledger import Ledger
from sessions.catalogue.records import Patient, User
from sessions.catalogue.rows import find_patient, patient_row, user_row, value_of, values_of
from sessions.catalogue.search import ORDERS, folded, words_of
from sessions.catalogue.tables import PatientRow, UserRow
from sessions.errors import Refused

_NAMESAKES = 50


class People(Ledger):
    """Users and patients."""

    def add_user(self, user: User) -> User:
        """Add a person who may sign in; its id and time are given here.

        Raises:
            Refused: The name is taken.
        """
        with self._writing() as session:
            if session.scalar(select(UserRow).where(UserRow.name == user.name)):
                raise Refused(f"user {user.name}", "already there", "a new name", "choose another name")
            row = UserRow(user.name, user.role, user.password_hash, user.active, self._clock_ns())
            session.add(row)
            session.flush()
            return value_of(User, row)

    def user(self, name: str) -> User:
        """A user by sign-in name.

        Raises:
            Refused: No user has that name.
        """
        with self._reading() as session:
            return value_of(User, user_row(session, name))

    def users(self) -> tuple[User, ...]:
        """All users by name."""
        with self._reading() as session:
            return tuple(sorted(values_of(session, User, select(UserRow)), key=lambda user: user.name))

    def change_user(self, user: User) -> User:
        """Write role, password hash and activity of the user with this name.

        Raises:
            Refused: No user has that name.
        """
        with self._writing() as session:
            row = user_row(session, user.name)
            row.role, row.password_hash, row.active = user.role, user.password_hash, user.active
            return value_of(User, row)

    def add_patient(self, patient: Patient) -> Patient:
        """Add a patient; the pseudonym (P-0001 and so on) is given here, unless the patient brings one.

        Raises:
            Refused: The pseudonym is taken.
        """
        with self._writing() as session:
            number = 1 + (session.scalar(select(func.max(PatientRow.number))) or 0)
            while not patient.id and find_patient(session, f"P-{number:04d}"):
                number += 1
            pseudonym = patient.id or f"P-{number:04d}"
            if find_patient(session, pseudonym):
                raise Refused(f"patient {pseudonym}", "already there", "a new pseudonym", "leave it out")
            row = PatientRow(
                pseudonym,
                patient.given_name,
                patient.family_name,
                patient.birth_date,
                patient.side,
                patient.hand_length_m,
                patient.impairment,
                patient.archived,
                self._clock_ns(),
                1,
            )
            session.add(row)
            session.flush()
            return value_of(Patient, row)

    def patient(self, pseudonym: str) -> Patient:
        """A patient by pseudonym.

        Raises:
            Refused: No patient has it.
        """
        with self._reading() as session:
            return value_of(Patient, patient_row(session, pseudonym))

    def patients(self, *, archived: bool = False) -> tuple[Patient, ...]:
        """Patients by pseudonym; the archived ones only when asked for."""
        with self._reading() as session:
            rows = session.scalars(
                select(PatientRow).where(PatientRow.archived == archived).order_by(PatientRow.number)
            )
            return tuple(value_of(Patient, row) for row in rows)

    def find_patients(
        self, typed: str = "", *, archived: bool = False, order: str = "name", start: int = 0, count: int = 50
    ) -> tuple[tuple[Patient, ...], int]:
        """Patients whose name, birth date or pseudonym holds every word that was typed.

        Args:
            typed: Words; accents and case do not matter, empty for everybody.
            archived: Among the archived ones, else among the others.
            order: One of ORDERS; a leading "-" turns it round.
            start: How many to leave out at the beginning.
            count: At most so many.

        Returns:
            Those patients, and how many there are in all.

        Raises:
            Refused: The order is unknown.
        """
        key = order.removeprefix("-")
        if key not in ORDERS:
            raise Refused("order of patients", repr(order[:40]), "one of " + ", ".join(ORDERS), "choose one")
        words = words_of(typed)
        with self._reading() as session:
            fits = [PatientRow.archived == archived]
            fits += [PatientRow.sought.contains(word, autoescape=True) for word in words]
            total = session.scalar(select(func.count()).select_from(PatientRow).where(*fits)) or 0
            query = select(PatientRow).where(*fits).order_by(*_order(key, turned=order.startswith("-")))
            return values_of(session, Patient, query.offset(start).limit(count)), total

    def namesakes(self, given_name: str, family_name: str, birth_date: str) -> tuple[Patient, ...]:
        """Patients of the same name or the same birth date, the archived among them."""
        name = folded(f"{given_name} {family_name}")
        same = [PatientRow.sought.startswith(f"{name} ", autoescape=True)] if name else []
        same += [PatientRow.birth_date == birth_date] if birth_date else []
        if not same:
            return ()
        with self._reading() as session:
            query = select(PatientRow).where(or_(*same)).order_by(PatientRow.number)
            found = values_of(session, Patient, query)
        alike = (
            one
            for one in found  # a longer name begins with this one too
            if folded(f"{one.given_name} {one.family_name}") == name or birth_date == one.birth_date != ""
        )
        return tuple(islice(alike, _NAMESAKES))

    def change_patient(self, patient: Patient) -> Patient:
        """Write everything of the patient with this pseudonym, archived or not among it.

        Raises:
            Refused: No patient has the pseudonym, or somebody else changed the patient since this version.
        """
        with self._writing() as session:
            row = patient_row(session, patient.id)
            if row.version != patient.version:
                value = f"changed by somebody else (version {row.version}, yours was {patient.version})"
                raise Refused(
                    f"patient {patient.id}", value, "unchanged since you opened it", "compare and save again"
                )
            row.version += 1
            row.given_name, row.family_name, row.birth_date = (
                patient.given_name,
                patient.family_name,
                patient.birth_date,
            )
            row.side, row.hand_length_m = patient.side, patient.hand_length_m
            row.impairment, row.archived = patient.impairment, patient.archived
            return value_of(Patient, row)


def _order(key: str, *, turned: bool) -> tuple[ColumnElement[Any], ...]:
    """The columns that one of ORDERS sorts by; equal dates and sides stand in the order of pseudonyms."""
    number: ColumnElement[Any] = PatientRow.number.expression
    if key == "added":
        return (number.desc() if turned else number,)
    if key == "name":
        name = PatientRow.sorted_name.expression
        return (name.desc(), number.desc()) if turned else (name, number)
    column = (PatientRow.birth_date if key == "birth" else PatientRow.side).expression
    return (column.desc() if turned else column, number)
