"""The age format (https://age-encryption.org/v1) through pyrage, which has no types: here it gets them."""

from __future__ import annotations

from importlib import import_module
from typing import IO, Any

_age: Any = import_module("pyrage")


class Unreadable(Exception):
    """What was to be decrypted is damaged, cut, or locked with something else."""


class TooMuchWork(Unreadable):
    """The passphrase was locked with more work than this machine can do in a reasonable time now."""


_TRIES = 4
_WORK = "excessive work"
"""How age begins that refusal: it times the machine at every try, and a busy one seems slow."""


def new_identity() -> tuple[str, str]:
    """A new key pair as age writes it: the secret half and the public half."""
    identity: Any = _age.x25519.Identity.generate()
    return str(identity), str(identity.to_public())


def encrypt(source: IO[bytes], target: IO[bytes], recipient: str) -> None:
    """Encrypt a stream for the owner of a public half, in constant memory.

    Raises:
        OSError: The target cannot be written.
    """
    try:
        _age.encrypt_io(source, target, [_age.x25519.Recipient.from_str(recipient)])
    except _age.EncryptError as error:  # carries only the text of what stopped it
        raise OSError(str(error)) from error


def decrypt(source: IO[bytes], target: IO[bytes], identity: str) -> None:
    """Decrypt a stream with a secret half, in constant memory.

    Raises:
        Unreadable: It was altered, cut or is for somebody else; the target may hold a part of it.
    """
    try:
        _age.decrypt_io(source, target, [_age.x25519.Identity.from_str(identity)])
    except (_age.DecryptError, _age.IdentityError, OSError) as error:
        raise Unreadable(str(error)) from error


def lock(text: str, passphrase: str) -> bytes:
    """Encrypt a short text with a passphrase (scrypt; takes seconds, as it should)."""
    locked: bytes = _age.passphrase.encrypt(text.encode("ascii"), passphrase)
    return locked


def unlock(locked: bytes, passphrase: str) -> str:
    """The text behind a passphrase.

    Raises:
        TooMuchWork: The machine is too busy, or far slower than the one that locked it.
        Unreadable: The passphrase is wrong or the content is damaged.
    """
    refused = ""
    for _ in range(_TRIES):
        try:
            text: bytes = _age.passphrase.decrypt(locked, passphrase)
            return text.decode("ascii")
        except (_age.DecryptError, OSError, UnicodeDecodeError) as error:
            refused = str(error)
            if _WORK not in refused.lower():
                raise Unreadable(refused) from error
    raise TooMuchWork(refused)
