"""The sentences in which a file is refused, and the guard that turns damage into them."""

from __future__ import annotations

from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path

from sessions.errors import Refused
from sessions.store.damage import Damaged

_SESSION = "a sealed session of rehab-app (MCAP)"


@contextmanager
def refusing(path: Path) -> Generator[None]:
    """Turn damage and a failing disk into a refusal that names the file."""
    try:
        yield
    except Damaged as error:
        raise damaged(path, str(error)) from error
    except OSError as error:
        raise unreadable(path, error) from error


def unreadable(path: Path, error: OSError) -> Refused:
    """The file is absent, a folder, or not ours to read."""
    why = (error.strerror or str(error)).lower()
    return Refused(_name(path), f"not readable ({why})", _SESSION, "check the path and its permissions")


def unwritable(partial: Path, error: OSError) -> Refused:
    """The disk is full, or refuses for another reason."""
    return Refused(
        f"session {_name(partial)}",
        f"not writable ({(error.strerror or str(error)).lower()})",
        "on a disk with free space that may be written to",
        "make room, then run rehab-app recover on it to keep what was written",
    )


def without_consent(topic: str) -> Refused:
    """An image for a session of a person who did not consent to images."""
    return Refused(
        f"image on {topic}", "without consent", "consented to", "ask for consent to images before recording"
    )


def empty(path: Path) -> Refused:
    """The file has no bytes."""
    return Refused(_name(path), "empty", _SESSION, "choose another file")


def no_mcap(path: Path, start: bytes) -> Refused:
    """The file does not begin as MCAP does."""
    value = f"no MCAP file (it begins with {start[:8]!r})"
    return Refused(_name(path), value, _SESSION, "use rehab-app import for recordings in other formats")


def cut(path: Path) -> Refused:
    """A session that was never sealed, or lost its end."""
    remedy = f"run rehab-app recover {path.name} to restore what was written"
    return Refused(_name(path), "cut short (its index is missing)", _SESSION, remedy)


def damaged(path: Path, why: str) -> Refused:
    """A session whose bytes contradict each other."""
    remedy = f"take a backup, or run rehab-app recover {path.name} to keep what is whole"
    return Refused(_name(path), f"damaged: {why}", _SESSION, remedy)


def foreign(path: Path, what: str) -> Refused:
    """An MCAP file of another program."""
    bound = f"{_SESSION}, which has a metadata record 'session' and protobuf topics such as /hand/pose"
    return Refused(_name(path), what, bound, "open it with the program that made it")


def altered(path: Path, met: str, expected: str) -> Refused:
    """A file that is not the one whose digest was noted."""
    return Refused(
        f"SHA-256 of {path.name!r}", met, f"{expected}, as noted beside it", "take the file from a backup"
    )


def _name(path: Path) -> str:
    return f"file {path.name!r}"
