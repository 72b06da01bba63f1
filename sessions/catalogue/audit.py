"""The hash chain of the audit: a row that is changed, removed or slipped in breaks it."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable
from dataclasses import dataclass

from sessions.catalogue.records import AuditRow
from sessions.errors import Refused


@dataclass(frozen=True, slots=True)
class ChainEnd:
    """How far a chain was followed.

    Attributes:
        rows: Rows that follow from each other, from the first.
        head: Hash of the last of them, empty where there is none.
    """

    rows: int = 0
    head: str = ""


START = ChainEnd()


def chained(
    previous: AuditRow | None, *, utc_ns: int, actor: str, verb: str, subject: str, detail: str
) -> AuditRow:
    """The row that follows ``previous`` (None for the first)."""
    seq = previous.seq + 1 if previous else 1
    before = previous.hash if previous else ""
    own = digest(seq, utc_ns, actor, verb, subject, detail, before)
    return AuditRow(
        seq=seq,
        utc_ns=utc_ns,
        actor=actor,
        verb=verb,
        subject=subject,
        detail=detail,
        previous_hash=before,
        hash=own,
    )


def digest(seq: int, utc_ns: int, actor: str, verb: str, subject: str, detail: str, before: str) -> str:
    """SHA-256 over the fields as one JSON array, so that no two rows read alike."""
    content = json.dumps([seq, utc_ns, actor, verb, subject, detail, before], ensure_ascii=True)
    return hashlib.sha256(content.encode()).hexdigest()


def follow(rows: Iterable[AuditRow], after: ChainEnd = START) -> ChainEnd:
    """Follow the chain.

    Args:
        rows: Rows in their order, the first of which follows ``after``.
        after: How far the chain was followed before.

    Returns:
        Its new end.

    Raises:
        Refused: A row does not follow from the one before it.
    """
    before, expected = after.head, after.rows
    for row in rows:
        expected += 1
        if row.seq != expected or row.previous_hash != before or not is_itself(row):
            raise broken(row.seq, expected)
        before = row.hash
    return ChainEnd(expected, before)


def is_itself(row: AuditRow) -> bool:
    """Whether a row's hash is that of what it says."""
    own = digest(row.seq, row.utc_ns, row.actor, row.verb, row.subject, row.detail, row.previous_hash)
    return row.hash == own


def broken(seq: int, expected: int) -> Refused:
    """What is said of a row that is not what was written.

    Args:
        seq: Its number.
        expected: The number that it must have.
    """
    return Refused(
        f"audit row {seq}",
        "not what was written",
        f"row {expected} of an unbroken chain",
        "restore the data base from a backup and find out who changed it",
    )
