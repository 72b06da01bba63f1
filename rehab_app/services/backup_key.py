"""The clinic's backup key: backups are locked with its public half, and opened with a passphrase only.

The format is age: X25519 for the backups, scrypt for the passphrase that locks the secret half. Whoever has
the passphrase can open a backup with the age tool alone.
"""

from __future__ import annotations

import base64
from dataclasses import dataclass

import msgspec

from rehab_app.errors import Refused
from rehab_app.services import age

SHORTEST, LONGEST = 12, 200


@dataclass(frozen=True, slots=True)
class BackupKey:
    """What may be kept in the clinic: it locks backups and opens none without the passphrase.

    Attributes:
        recipient: Public half, as age writes it.
        locked: Secret half, locked with the passphrase (age, scrypt), base64.
    """

    recipient: str
    locked: str


def new_key(passphrase: str) -> BackupKey:
    """Draw a key and lock its secret half.

    Raises:
        Refused: The passphrase is shorter than 12 or longer than 200 characters.
    """
    if not SHORTEST <= len(passphrase) <= LONGEST:
        length = f"{len(passphrase)} characters long"
        bound = f"{SHORTEST} to {LONGEST} characters"
        raise Refused("backup passphrase", length, bound, "choose a sentence and keep it in a safe")
    secret, public = age.new_identity()
    return BackupKey(public, base64.b64encode(age.lock(secret, passphrase)).decode("ascii"))


def unlock(locked: bytes, passphrase: str) -> str:
    """The secret half.

    Args:
        locked: What age wrote.
        passphrase: What locks it.

    Raises:
        Refused: The passphrase is wrong or the key is damaged, or the machine is too busy to try it.
    """
    try:
        return age.unlock(locked, passphrase[: LONGEST + 1])
    except age.TooMuchWork:
        raise Refused(
            "backup passphrase",
            "locked with more work than this machine can do now",
            "at most sixteen times what it seems able to do in a second",
            "try again when nothing else runs on it, or on a faster machine",
        ) from None
    except age.Unreadable:
        raise Refused(
            "backup passphrase",
            "wrong, or the backup's key is damaged",
            "the one that was set when the backup was made",
            "type it again",
        ) from None


def key_to_json(key: BackupKey) -> str:
    """The key as a setting of the clinic."""
    return msgspec.json.encode(key).decode()


def key_from_json(text: str) -> BackupKey:
    """The key from a setting."""
    return msgspec.json.decode(text, type=BackupKey)
