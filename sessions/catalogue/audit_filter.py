"""Which rows of the audit are wanted."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class AuditFilter:
    """Rows must fit all that is given; what is empty or 0 fits every row.

    Attributes:
        actor: Who.
        verb: What was done.
        subject: To what, exactly.
        from_utc_ns: Not before.
        until_utc_ns: Before.
    """

    actor: str = ""
    verb: str = ""
    subject: str = ""
    from_utc_ns: int = 0
    until_utc_ns: int = 0
