"""Passwords are kept as Argon2id hashes (RFC 9106, the library's low-memory profile), never as they are."""

from __future__ import annotations

from argon2 import PasswordHasher
from argon2.exceptions import InvalidHashError, VerificationError
from argon2.profiles import RFC_9106_LOW_MEMORY

from rehab_app.errors import Refused

SHORTEST = 10
LONGEST = 200
_hasher = PasswordHasher.from_parameters(RFC_9106_LOW_MEMORY)


def hash_password(password: str) -> str:
    """Argon2id hash of a new password, with its own salt.

    Raises:
        Refused: The password is shorter than 10 or longer than 200 characters.
    """
    if not SHORTEST <= len(password) <= LONGEST:
        raise Refused(
            "password",
            f"{len(password)} characters long",
            f"{SHORTEST} to {LONGEST} characters",
            "choose a sentence that you can remember",
        )
    return _hasher.hash(password)


def verify_password(stored: str, password: str) -> bool:
    """Whether the password belongs to the hash. A stored text that is no hash matches nothing."""
    try:
        return _hasher.verify(stored, password[: LONGEST + 1])
    except (VerificationError, InvalidHashError):
        return False
