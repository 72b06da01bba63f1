"""Approvals that are taken back: anybody who treats may, with a reason."""

from __future__ import annotations

from dataclasses import dataclass

import msgspec

from rehab_app.access import Account, require
from rehab_app.errors import Refused
from rehab_app.services.audit import Audit
from rehab_app.services.plain_text import many_lines, needed
from sessions.catalogue import Catalogue, Setting

_LONGEST_REASON = 500


@dataclass(frozen=True, slots=True)
class Withdrawal:
    """Why a take is not approved any more.

    Attributes:
        by: Who withdrew the approval.
        reason: Why.
        utc_ns: When.
    """

    by: str
    reason: str
    utc_ns: int = 0


class Approvals:
    """Withdraws approvals.

    Args:
        catalogue: The clinic's catalogue.
        audit: Where withdrawals are noted.
    """

    def __init__(self, catalogue: Catalogue, audit: Audit) -> None:
        self._catalogue = catalogue
        self._audit = audit

    def withdraw(self, take: str, by: Account, reason: str) -> Withdrawal:
        """Take an approval back: from now on the take cannot be played. Safer is anyone's who treats.

        Args:
            take: Catalogue id.
            by: Who does it (verb "note").
            reason: Why; it is shown with the take.

        Raises:
            Refused: The account may not, the take is unknown or not approved, or no reason is given.
        """
        require(by, "note")
        thing = "reason for the withdrawal"
        why = needed(thing, many_lines(thing, reason, _LONGEST_REASON))
        row = self._catalogue.take(take)
        if self._catalogue.approval(row.id) is None:
            raise Refused(f"take {row.id}", "not approved", "approved", "nothing has to be withdrawn")
        self._catalogue.withdraw(row.id, by.name)
        said = Withdrawal(by.name, why)
        self._catalogue.set(Setting(key=_key(row.id), content=msgspec.json.encode(said).decode(), by=by.name))
        self._audit.note(by, "withdraw approval", row.id, row.sha256)
        return said

    def withdrawal(self, take: str) -> Withdrawal | None:
        """The withdrawal that holds for a take, None where it is approved or nobody withdrew anything.

        Raises:
            Refused: The take is unknown.
        """
        row = self._catalogue.take(take)
        kept = None if self._catalogue.approval(row.id) else self._catalogue.setting(_key(row.id))
        if kept is None:
            return None
        said = msgspec.json.decode(kept.content, type=Withdrawal)
        return Withdrawal(kept.by, said.reason, kept.created_utc_ns)


def _key(take: str) -> str:
    """Key of the setting; an id grows beyond 40 characters only where 40 of two digests are the same."""
    return f"withdrawal:{take[:40]}"
