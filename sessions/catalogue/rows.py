"""Between table rows and frozen values; ids, and the refusals of what is unknown or already there."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields
from pathlib import PurePosixPath
from typing import Any, TypeVar, cast

from sqlalchemy import Select, select
from sqlalchemy.orm import Session

from sessions.catalogue.tables import PatientRow, Table, TakeRow, TherapySessionRow, UserRow
from sessions.catalogue.texts import storable
from sessions.errors import Refused

V = TypeVar("V")
R = TypeVar("R", TakeRow, TherapySessionRow)
SHORTEST_ID = 8
SHORTEST_PREFIX = 6


def value_of(kind: type[V], row: Table) -> V:
    """The frozen value of a row; NULL becomes the empty string."""
    content: dict[str, Any] = {}
    for item in fields(cast(Any, kind)):
        found: Any = getattr(row, item.name)
        content[item.name] = "" if found is None else found
    return kind(**content)


def values_of(session: Session, kind: type[V], query: Select[Any]) -> tuple[V, ...]:
    """The frozen values of every row that a query of one table finds; for thousands of rows.

    Only the columns that the value has are read, and no row object is made of them.

    Args:
        session: The transaction.
        kind: The frozen value.
        query: ``select`` of one table, with its conditions and order.
    """
    names = [item.name for item in fields(cast(Any, kind))]
    columns: Any = query.column_descriptions[0]["entity"]
    asked = query.with_only_columns(*(getattr(columns, name) for name in names), maintain_column_froms=True)
    return tuple(
        kind(**{name: "" if found is None else found for name, found in zip(names, row, strict=True)})
        for row in session.execute(asked)
    )


def short_id(sha256: str, taken: Callable[[str], bool]) -> str:
    """The first 8 characters of a digest, or as many more as make it unique.

    Args:
        sha256: SHA-256, hexadecimal.
        taken: Whether an id is already in use.

    Raises:
        Refused: The digest is not 64 hexadecimal digits.
    """
    if len(sha256) != 64 or not set(sha256) <= set("0123456789abcdef"):
        raise Refused(
            "file digest",
            repr(sha256[:70]),
            "64 hexadecimal digits",
            "seal the file first, it is then written",
        )
    length = next(n for n in range(SHORTEST_ID, 65) if not taken(sha256[:n]))
    return sha256[:length]


def by_id(session: Session, kind: type[R], text: str, thing: str, remedy: str) -> R:
    """A take or session by id, by digest, or by six or more leading characters of the digest.

    Raises:
        Refused: None has it, or several have.
    """
    exact = session.get(kind, text) if storable(text) else None
    if exact is not None:
        return exact
    found: list[R] = []
    if len(text) >= SHORTEST_PREFIX and set(text) <= set("0123456789abcdef"):
        found = list(session.scalars(select(kind).where(kind.sha256.startswith(text)).limit(2)))
    if len(found) > 1:
        raise Refused(f"{thing} {text}", "ambiguous", "one file", "give more characters of its id")
    if not found:
        raise Refused(
            f"{thing} {text[:70]!r}", "unknown", f"the id of a {thing} in this clinic folder", remedy
        )
    return found[0]


def relative(path: str) -> str:
    """A path as the catalogue keeps it: POSIX, relative to the clinic folder.

    Raises:
        Refused: It is absolute or leaves the folder.
    """
    pure = PurePosixPath(path)
    if pure.is_absolute() or ".." in pure.parts or not pure.parts:
        raise Refused("file path", repr(path), "inside the clinic folder", "copy the file into it first")
    return str(pure)


def take_row(session: Session, take: str) -> TakeRow:
    """A take by id.

    Raises:
        Refused: None has it.
    """
    return by_id(session, TakeRow, take, "take", "list the takes of the clinic, or give the path of a file")


def user_row(session: Session, name: str) -> UserRow:
    """A user by name.

    Raises:
        Refused: None has it.
    """
    row = session.scalar(select(UserRow).where(UserRow.name == name)) if storable(name) else None
    if row is None:
        raise Refused(
            f"user {name!r}", "unknown", "a user of this clinic", "add the user with rehab-app user"
        )
    return row


def find_patient(session: Session, pseudonym: str) -> PatientRow | None:
    """A patient by pseudonym, None where nobody has it."""
    if not storable(pseudonym):
        return None
    return session.scalar(select(PatientRow).where(PatientRow.id == pseudonym))


def patient_row(session: Session, pseudonym: str) -> PatientRow:
    """A patient by pseudonym.

    Raises:
        Refused: Nobody has it.
    """
    row = find_patient(session, pseudonym)
    if row is None:
        raise Refused(
            f"patient {pseudonym!r}",
            "unknown",
            "the pseudonym of a patient of this clinic",
            "add the patient with rehab-app patient",
        )
    return row


def refuse_path(taken_by: str | None, path: str) -> None:
    """Two recordings cannot share a file.

    Raises:
        Refused: The path belongs to another recording.
    """
    if taken_by is not None:
        raise Refused(
            f"file {path}", f"that of {taken_by}", "a file of its own", "give the file another name"
        )
