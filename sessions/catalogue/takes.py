"""Verbs about what was demonstrated: exercises, takes and their approval."""

from __future__ import annotations

from sqlalchemy import Select, func, select

from sessions.catalogue.ledger import Ledger
from sessions.catalogue.records import Approval, Exercise, Take
from sessions.catalogue.rows import refuse_path, relative, short_id, take_row, value_of, values_of
from sessions.catalogue.tables import ApprovalRow, ExerciseRow, TakeRow
from sessions.errors import Refused

_NO_FILE = ""
"""Digest in a row that withdraws an approval."""


class Takes(Ledger):
    """Exercises, takes and approvals."""

    def add_exercise(self, exercise: Exercise) -> Exercise:
        """Add an exercise, or change the description of the one with this name."""
        with self._writing() as session:
            session.merge(ExerciseRow(exercise.name, exercise.description))
            return exercise

    def exercises(self) -> tuple[Exercise, ...]:
        """The library by name."""
        with self._reading() as session:
            found = values_of(session, Exercise, select(ExerciseRow))
            return tuple(sorted(found, key=lambda exercise: exercise.name))

    def add_take(self, take: Take) -> Take:
        """Add a sealed take; its id is given here. A file that is there already is given back as it is.

        Raises:
            Refused: The digest or path is not one, or the parent is unknown.
        """
        path = relative(take.path)
        with self._writing() as session:
            known = session.scalar(select(TakeRow).where(TakeRow.sha256 == take.sha256))
            if known is not None:
                return value_of(Take, known)
            given = short_id(take.sha256, lambda text: session.get(TakeRow, text) is not None)
            parent = take_row(session, take.parent).id if take.parent else None
            row = TakeRow(
                given,
                take.sha256,
                path,
                take.side,
                take.exercise,
                take.source,
                take.duration_s,
                take.subject_id,
                parent,
                take.author,
                take.reason,
                take.retouch,
                self._clock_ns(),
            )
            refuse_path(session.scalar(select(TakeRow.id).where(TakeRow.path == path)), path)
            session.add(row)
            return value_of(Take, row)

    def take(self, take: str) -> Take:
        """A take by id, digest or unique beginning of it.

        Raises:
            Refused: No take has it.
        """
        with self._reading() as session:
            return value_of(Take, take_row(session, take))

    def takes(self) -> tuple[Take, ...]:
        """All takes, newest first."""
        with self._reading() as session:
            return values_of(session, Take, _newest_first())

    def takes_of(self, subject: str) -> tuple[Take, ...]:
        """Takes of one person's own hands by pseudonym, newest first."""
        with self._reading() as session:
            return values_of(session, Take, _newest_first().where(TakeRow.subject_id == subject))

    def approve(self, take: str, by: str) -> Approval:
        """Record a therapist's approval of exactly this file. Whether ``by`` may approve is for services.

        Raises:
            Refused: No take has that id, or nobody is named.
        """
        if not by.strip():
            raise Refused("approval", "by nobody", "by a named therapist", "name the user with --by")
        with self._writing() as session:
            found = take_row(session, take)
            row = ApprovalRow(found.id, by.strip(), self._clock_ns(), found.sha256)
            session.add(row)
            return value_of(Approval, row)

    def withdraw(self, take: str, by: str) -> None:
        """Take the approval of a take back: a newer row that approves no file.

        Raises:
            Refused: No take has that id, or nobody is named.
        """
        if not by.strip():
            raise Refused("withdrawal", "by nobody", "by a named user", "name the user with --by")
        with self._writing() as session:
            session.add(ApprovalRow(take_row(session, take).id, by.strip(), self._clock_ns(), _NO_FILE))

    def approvals(self, takes: tuple[str, ...] | None = None) -> dict[str, Approval]:
        """The approvals that hold now, by the id of their take: one query for a whole list.

        Args:
            takes: Ids of the few takes that are meant, None for all.
        """
        newest = select(func.max(ApprovalRow.id)).join(TakeRow, TakeRow.id == ApprovalRow.take)
        if takes is not None:
            newest = newest.where(ApprovalRow.take.in_(takes))
        known = newest.where(ApprovalRow.digest.in_((TakeRow.sha256, _NO_FILE))).group_by(ApprovalRow.take)
        with self._reading() as session:
            rows = values_of(session, Approval, select(ApprovalRow).where(ApprovalRow.id.in_(known)))
            return {row.take: row for row in rows if row.digest != _NO_FILE}

    def approval(self, take: str) -> Approval | None:
        """The approval that holds for a take, None where it was never approved or was withdrawn since.

        Raises:
            Refused: No take has that id.
        """
        with self._reading() as session:
            found = take_row(session, take)
            query = select(ApprovalRow).where(
                ApprovalRow.take == found.id, ApprovalRow.digest.in_((found.sha256, _NO_FILE))
            )
            row = session.scalar(query.order_by(ApprovalRow.id.desc()).limit(1))
            return None if row is None or row.digest == _NO_FILE else value_of(Approval, row)


def _newest_first() -> Select[TakeRow]:
    return select(TakeRow).order_by(TakeRow.created_utc_ns.desc(), TakeRow.id)
