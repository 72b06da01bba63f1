"""Sign-in tickets: what the cookie says, signed with the clinic's own key.

The server remembers each sign-in besides (``services.sign_ins``) and asks there whether it still holds. The
signature alone says who presses the stop: that path asks no data base.
"""

from __future__ import annotations

import hashlib
import os
import secrets
from dataclasses import dataclass
from pathlib import Path

from itsdangerous import BadSignature, Signer, URLSafeTimedSerializer

from rehab_app.services.sign_ins import LIFETIME_S

_KEY_BYTES = 32
_SECRET_BYTES = 32


@dataclass(frozen=True, slots=True)
class Ticket:
    """One sign-in.

    Attributes:
        name: Name of the account.
        id: Secret of this sign-in, 256 random bits.
    """

    name: str
    id: str

    @property
    def digest(self) -> str:
        """SHA-256 of the secret: what the server remembers."""
        return hashlib.sha256(self.id.encode()).hexdigest()


class Seal:
    """Issues and reads tickets.

    Args:
        key: Secret of the clinic.
    """

    def __init__(self, key: bytes) -> None:
        self._tickets = URLSafeTimedSerializer(key, salt="sign-in")
        self._notices = URLSafeTimedSerializer(key, salt="notice")
        self._forms = Signer(key, salt="form")

    def issue(self, name: str) -> str:
        """Cookie text of a new sign-in; it is worth something once the server remembers it."""
        return str(self._tickets.dumps({"name": name, "id": secrets.token_hex(_SECRET_BYTES)}))

    def read(self, text: str | None) -> Ticket | None:
        """The ticket in a cookie; None where it is absent, forged, or older than ten hours."""
        return self._read(text, LIFETIME_S)

    def read_old(self, text: str | None) -> Ticket | None:
        """The same whatever its age: it says who sat here, and opens nothing."""
        return self._read(text, None)

    def _read(self, text: str | None, max_age_s: int | None) -> Ticket | None:
        if not text:
            return None
        try:
            said = self._tickets.loads(text, max_age=max_age_s)
        except BadSignature:
            return None
        return Ticket(str(said["name"]), str(said["id"]))

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
