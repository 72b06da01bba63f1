"""Values of the clinic's daily writing."""

from __future__ import annotations

from dataclasses import dataclass

from sessions.errors import Refused

ENTRY_KINDS = (
    "note",
    "pain",
    "adverse-event",
    "check-in",
    "outcome",
    "plan",
    "consent",
    "proposal",
    "assessment",
)
"""note: free text. pain: one tap or a score. adverse-event: what went wrong. check-in: the questions before a
session. outcome: a score of the clinic's own, ``topic`` names the measure. plan: the standing prescription.
consent: ``topic`` says to what. proposal: a change of therapy, accepted or not. assessment: its result."""
LONGEST_CONTENT = 100_000


@dataclass(frozen=True, slots=True, kw_only=True)
class PatientEntry:
    """Something that was written about a patient. Entries are added; none is changed.

    Attributes:
        id: Number in the catalogue, 0 before it is added.
        patient: Pseudonym.
        kind: One of ENTRY_KINDS.
        topic: What it is about, such as the name of an outcome measure; may be empty.
        session: Id of the therapy session it belongs to, empty for none.
        content: JSON of it; the service that owns the kind gives it a type.
        by: Who wrote it.
        created_utc_ns: When.

    Raises:
        Refused: The kind is unknown or the content is too long.
    """

    id: int = 0
    patient: str
    kind: str
    topic: str = ""
    session: str = ""
    content: str
    by: str
    created_utc_ns: int = 0

    def __post_init__(self) -> None:
        if self.kind not in ENTRY_KINDS:
            raise Refused("kind of entry", repr(self.kind), "one of " + ", ".join(ENTRY_KINDS), "choose one")
        if len(self.content) > LONGEST_CONTENT:
            length = f"{len(self.content)} characters long"
            raise Refused(self.kind, length, f"at most {LONGEST_CONTENT} characters", "shorten it")


@dataclass(frozen=True, slots=True, kw_only=True)
class SignIn:
    """One sign-in of a user.

    Attributes:
        id: SHA-256 of the secret in the cookie, hexadecimal; the secret itself is nowhere.
        user: Name of the user.
        issued_utc_ns: When.
        seen_utc_ns: When it was last used, to the minute.
        ended_utc_ns: When it was ended, 0 while it holds.
    """

    id: str
    user: str
    issued_utc_ns: int = 0
    seen_utc_ns: int = 0
    ended_utc_ns: int = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class Setting:
    """One version of a setting of the clinic.

    Attributes:
        id: Number in the catalogue, 0 before it is added.
        key: Which setting.
        content: JSON of its value.
        by: Who set it.
        created_utc_ns: When.
    """

    id: int = 0
    key: str
    content: str
    by: str
    created_utc_ns: int = 0
