"""Versions that are only added: whoever writes over one that they have not read is told."""

from __future__ import annotations

from typing import Any, Protocol

from sqlalchemy import ColumnElement, select
from sqlalchemy.orm import Session

from sessions.errors import Refused


class Version(Protocol):
    """A row whose newest one counts."""

    id: Any
    by: Any


def check_newest(
    session: Session, kind: type[Version], *which: ColumnElement[bool], since: int | None, thing: str
) -> None:
    """Refuse to write a version over one that somebody else wrote meanwhile.

    Args:
        session: The writing transaction, which nobody else's comes between.
        kind: Table.
        which: Which of its rows are versions of one thing.
        since: Number of the version that the writer had read, 0 where there was none; None if it does not
            matter.
        thing: What it is, in words.

    Raises:
        Refused: There is a newer one.
    """
    if since is None:
        return
    row = session.scalar(select(kind).where(*which).order_by(kind.id.desc()).limit(1))
    newest = 0 if row is None else int(row.id)
    if row is not None and newest != since:
        raise Refused(
            thing,
            f"changed by {row.by} meanwhile (version {newest}, yours was {since})",
            "unchanged since you opened it",
            "compare and save again",
        )
