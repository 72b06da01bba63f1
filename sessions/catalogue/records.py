"""What the catalogue holds, as frozen values; the tables behind them never leave this package."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import date

from sessions.errors import Refused
from sessions.records import SIDES, Side

ROLES = ("administrator", "therapist", "assistant", "patient", "auditor")


@dataclass(frozen=True, slots=True, kw_only=True)
class User:
    """A person who may sign in.

    Attributes:
        id: Number in the catalogue, 0 before it is added.
        name: Sign-in name, unique.
        role: One of ROLES.
        password_hash: Argon2 hash; the catalogue never sees a password.
        active: Whether signing in is allowed.
        created_utc_ns: When it was added.
    """

    id: int = 0
    name: str
    role: str
    password_hash: str
    active: bool = True
    created_utc_ns: int = 0

    def __post_init__(self) -> None:
        if self.role not in ROLES:
            raise Refused("role", repr(self.role), "one of " + ", ".join(ROLES), "choose a role")
        if not self.name.strip():
            raise Refused("user name", "empty", "1 character or more", "name the user")


@dataclass(frozen=True, slots=True, kw_only=True)
class Patient:
    """A patient. Names stay in the catalogue; files carry the pseudonym only.

    Attributes:
        id: Pseudonym such as P-0001; empty before it is added.
        given_name: Given name, may be empty.
        family_name: Family name, may be empty.
        birth_date: ISO date, may be empty.
        side: Affected side.
        hand_length_m: Wrist crease to middle fingertip.
        impairment: Note on the impairment.
        archived: Whether the patient is hidden from lists.
        created_utc_ns: When it was added.
        version: Rises with every change, from 1; a change must name the version that it was made from.
    """

    id: str = ""
    given_name: str = ""
    family_name: str = ""
    birth_date: str = ""
    side: Side
    hand_length_m: float = 0.189
    impairment: str = ""
    archived: bool = False
    created_utc_ns: int = 0
    version: int = 1

    def __post_init__(self) -> None:
        if self.side not in SIDES:
            raise Refused("affected side", repr(self.side), "left or right", "name the side of the hand")
        if not 0.1 <= self.hand_length_m <= 0.3:
            raise Refused(
                "hand length",
                f"{self.hand_length_m:g} m",
                "0.1 to 0.3 m",
                "measure from the wrist crease to the tip of the middle finger",
            )
        if self.birth_date and not is_date(self.birth_date):
            raise Refused(
                "birth date", repr(self.birth_date), "a date as YYYY-MM-DD", "correct it or leave it empty"
            )


@dataclass(frozen=True, slots=True, kw_only=True)
class Exercise:
    """An exercise of the library.

    Attributes:
        name: Unique name.
        description: What it is for.
    """

    name: str
    description: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Take:
    """A recorded demonstration.

    Attributes:
        id: Short id: the first characters of its SHA-256, as many as make it unique (8 or more).
        sha256: SHA-256 of the file.
        path: Path relative to the clinic folder.
        side: Side of the recorded hand.
        exercise: Name of the exercise or movement.
        source: Where the motion came from.
        duration_s: Length.
        subject_id: Pseudonym of the person whose hand it is.
        parent: Id of the take this one was retouched from, empty if none.
        author: Who retouched it, empty if nobody.
        reason: Why.
        retouch: JSON of what was done to the parent, empty if nothing.
        created_utc_ns: When it was added.
    """

    id: str = ""
    sha256: str
    path: str
    side: Side
    exercise: str
    source: str
    duration_s: float
    subject_id: str
    parent: str = ""
    author: str = ""
    reason: str = ""
    retouch: str = ""
    created_utc_ns: int = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class Approval:
    """A therapist's word that a take may be played.

    Attributes:
        take: Id of the take.
        by: Name of the user who approved.
        utc_ns: When.
        digest: SHA-256 of the file that was approved; another file is not approved.
    """

    take: str
    by: str
    utc_ns: int
    digest: str


@dataclass(frozen=True, slots=True, kw_only=True)
class PrescriptionRow:
    """What was ordered for a patient.

    Attributes:
        id: Number in the catalogue, 0 before it is added.
        patient: Pseudonym.
        take: Id of the take.
        mode: Therapy mode.
        speed: Path speed, 1 is the therapist's own.
        repetitions: How many times.
        stiffness_multiple: Stiffness as a multiple of the thesis gains.
        limits: JSON of the limits that hold.
        content: JSON of the whole prescription; empty of those made before it was kept.
        by: Who ordered it, likewise.
        created_utc_ns: When it was added.
    """

    id: int = 0
    patient: str
    take: str
    mode: str
    speed: float
    repetitions: int
    stiffness_multiple: float
    limits: str = ""
    content: str = ""
    by: str = ""
    created_utc_ns: int = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class TherapySession:
    """A run on the robot.

    Attributes:
        id: Short id, as of a take.
        patient: Pseudonym, empty where no patient was named.
        take: Id of the take that was played, empty of a run without one, such as a guided assessment.
        sha256: SHA-256 of the file.
        path: Path relative to the clinic folder.
        mode: Therapy mode.
        started_utc_ns: When it began.
    """

    id: str = ""
    patient: str = ""
    take: str = ""
    sha256: str
    path: str
    mode: str
    started_utc_ns: int


@dataclass(frozen=True, slots=True, kw_only=True)
class CameraCalibration:
    """One version of a camera's calibration.

    Attributes:
        id: Number in the catalogue, 0 before it is added.
        digest: SHA-256 that sessions store.
        camera: Id of the camera, such as ``webcam:0``.
        verdict: What it is worth, in one word.
        content: The calibration itself, JSON.
        created_utc_ns: When it was added.
    """

    id: int = 0
    digest: str
    camera: str
    verdict: str
    content: str
    created_utc_ns: int = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class Hand:
    """One version of a person's calibrated hand.

    Attributes:
        id: Number in the catalogue, 0 before it is added.
        person: Pseudonym of a patient or therapist; never a name.
        side: Side of the hand.
        protocol: Name of the marker protocol that it wore.
        content: The hand itself, JSON.
        created_utc_ns: When it was added.
    """

    id: int = 0
    person: str
    side: Side
    protocol: str
    content: str
    created_utc_ns: int = 0

    def __post_init__(self) -> None:
        if self.side not in SIDES:
            raise Refused("side of the hand", repr(self.side), "left or right", "name the side of the hand")
        if not self.person.strip():
            raise Refused("person of the hand", "nobody", "a pseudonym", "name the person with --subject")


@dataclass(frozen=True, slots=True, kw_only=True)
class AuditRow:
    """One entry of the audit; each carries the hash of the one before it.

    Attributes:
        seq: Number from 1, without gaps.
        utc_ns: When.
        actor: Who.
        verb: What was done, such as "approve".
        subject: To what, by id or pseudonym.
        detail: One sentence, never a patient's name.
        previous_hash: Hash of the row before, empty for the first.
        hash: SHA-256 over this row and ``previous_hash``.
    """

    seq: int
    utc_ns: int
    actor: str
    verb: str
    subject: str
    detail: str
    previous_hash: str
    hash: str


def is_date(text: str) -> bool:
    """Whether a text is a date as YYYY-MM-DD."""
    try:
        date.fromisoformat(text)
    except ValueError:
        return False
    return len(text) == len("2000-01-01")
