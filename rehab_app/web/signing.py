"""Sign-in tickets: what the cookie says, signed with the clinic's own key."""

from __future__ import annotations

import os
import secrets
import time
from dataclasses import dataclass
from pathlib import Path

from itsdangerous import BadSignature, Signer, URLSafeTimedSerializer

LIFETIME_S = 10 * 3600
_KEY_BYTES = 32


@dataclass(frozen=True, slots=True)
class Ticket:
    """One sign-in.

    Attributes:
        name: Name of the account.
        id: Random id of this sign-in, so that signing out ends exactly this one.
    """

    name: str
    id: str


class Seal:
    """Issues and reads tickets.

    Args:
        key: Secret of the clinic.
    """

    def __init__(self, key: bytes) -> None:
        self._tickets = URLSafeTimedSerializer(key, salt="sign-in")
        self._notices = URLSafeTimedSerializer(key, salt="notice")
        self._forms = Signer(key, salt="form")
        self._ended: dict[str, float] = {}

    def issue(self, name: str) -> str:
        """Cookie text of a new sign-in."""
        return str(self._tickets.dumps({"name": name, "id": secrets.token_hex(16)}))

    def read(self, text: str | None) -> Ticket | None:
        """The ticket in a cookie; None where it is absent, forged, expired or ended."""
        if not text:
            return None
        try:
            said = self._tickets.loads(text, max_age=LIFETIME_S)
        except BadSignature:
            return None
        ticket = Ticket(str(said["name"]), str(said["id"]))
        return None if ticket.id in self._ended else ticket

    def end(self, ticket: Ticket) -> None:
        """Sign out: the ticket is worth nothing from now on."""
        now_s = time.monotonic()
        self._ended = {key: at_s for key, at_s in self._ended.items() if now_s - at_s < LIFETIME_S}
        self._ended[ticket.id] = now_s

    def form_token(self, ticket: Ticket) -> str:
        """The token that every form of this sign-in carries."""
        return self._forms.get_signature(ticket.id).decode("ascii")

    def form_token_fits(self, ticket: Ticket, token: str) -> bool:
        """Whether a form came from a page of this sign-in."""
        return self._forms.verify_signature(ticket.id, token)

    def notice(self, text: str, good: bool) -> str:
        """Cookie text of a sentence for the next page."""
        return str(self._notices.dumps([text, good]))

    def read_notice(self, text: str | None) -> tuple[str, bool] | None:
        """The sentence and whether it is good news, None where there is none."""
        if not text:
            return None
        try:
            sentence, good = self._notices.loads(text, max_age=60)
        except BadSignature:
            return None
        return str(sentence), bool(good)


def clinic_key(path: Path) -> bytes:
    """The clinic's key: read, or drawn and written with mode 0600.

    Args:
        path: ``ClinicFolder.secret``.
    """
    if not path.exists():
        descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
        with os.fdopen(descriptor, "wb") as file:
            file.write(secrets.token_bytes(_KEY_BYTES))
    return path.read_bytes()
