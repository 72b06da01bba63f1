"""A person's hand, known from an earlier take."""

from __future__ import annotations

from pathlib import Path

from rehab_app.hand.subject import Subject, subject_from_json
from sessions.errors import Refused
from sessions.store import SessionReader


def subject_of(take: Path) -> Subject:
    """The hand, with its markers, that a take states.

    Raises:
        Refused: There is no such take, or it states no hand with markers.
    """
    if not take.is_file():
        raise Refused("--subject", repr(str(take)), "a take that exists", "check the path")
    with SessionReader(take) as reader:
        return subject_from_json(reader.header.subject_hand)
