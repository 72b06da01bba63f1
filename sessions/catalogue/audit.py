"""The hash chain of the audit: a row that is changed, removed or slipped in breaks it."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable

from sessions.catalogue.records import AuditRow
from sessions.errors import Refused


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


def verify(rows: Iterable[AuditRow]) -> int:
    """Follow the chain and count its rows.

    Raises:
        Refused: A row does not follow from the one before it.
    """
    before, expected = "", 0
    for row in rows:
        expected += 1
        own = digest(row.seq, row.utc_ns, row.actor, row.verb, row.subject, row.detail, row.previous_hash)
        if row.seq != expected or row.previous_hash != before or row.hash != own:
            raise Refused(
                f"audit row {row.seq}",
                "not what was written",
                f"row {expected} of an unbroken chain",
                "restore the data base from a backup and find out who changed it",
            )
        before = row.hash
    return expected
