"""What is known of a patient's hand and what was decided about it: each a version, none ever changed."""

from __future__ import annotations

import math
from dataclasses import dataclass

from sessions.catalogue.records import is_date
from sessions.errors import Refused
from sessions.records import SIDES, Side

MAS_GRADES = ("", "0", "1", "1+", "2", "3", "4")
"""Modified Ashworth grades; empty where nobody has tested."""
TORQUE_LIMIT = "tau_interaction_nm"
RANGE_LOW = "q_min_rad"
RANGE_HIGH = "q_max_rad"
CHANGEABLE = (TORQUE_LIMIT, RANGE_LOW, RANGE_HIGH)
"""Limits of one joint that a person may set."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ClinicalRecord:
    """One version of what therapy must know of a patient's hand; the newest counts.

    Attributes:
        id: Number in the catalogue, 0 before it is added.
        patient: Pseudonym.
        diagnosis: Key of a diagnosis template.
        event_date: ISO date of the stroke, injury or operation; empty where there is none.
        mas: Modified Ashworth grade of the finger flexors, one of MAS_GRADES.
        insensate: Whether the skin does not feel.
        unaware: Neglect or aphasia: the patient would not say that something hurts.
        rheumatoid: Rheumatoid arthritis.
        crps: Complex regional pain syndrome.
        hyperextension_allowed: Whether a therapist lets flexion joints go below 0 degrees.
        bones_m: JSON of measured bones, five digits of three; empty for average proportions.
        by: Who stated it.
        created_utc_ns: When it was added.
    """

    id: int = 0
    patient: str
    diagnosis: str
    event_date: str = ""
    mas: str = ""
    insensate: bool = False
    unaware: bool = False
    rheumatoid: bool = False
    crps: bool = False
    hyperextension_allowed: bool = False
    bones_m: str = ""
    by: str
    created_utc_ns: int = 0

    def __post_init__(self) -> None:
        if self.mas not in MAS_GRADES:
            bound = "one of " + ", ".join(grade for grade in MAS_GRADES if grade)
            raise Refused("Modified Ashworth grade", repr(self.mas), bound, "correct it or leave it out")
        if self.event_date and not is_date(self.event_date):
            raise Refused(
                "event date", repr(self.event_date), "a date as YYYY-MM-DD", "correct it or leave it out"
            )
        _named(self.by, "clinical record")


@dataclass(frozen=True, slots=True, kw_only=True)
class ModeUnlock:
    """A therapist's word that a mode may be used before its date, or that it may not after all.

    Attributes:
        id: Number in the catalogue, 0 before it is added.
        patient: Pseudonym.
        mode: Therapy mode.
        diagnosis: Diagnosis for which it was given; another one is locked again.
        event_date: Event for which it was given, likewise.
        unlocked: False takes an earlier one back.
        reason: Why.
        by: Who.
        created_utc_ns: When.
    """

    id: int = 0
    patient: str
    mode: str
    diagnosis: str
    event_date: str
    unlocked: bool
    reason: str
    by: str
    created_utc_ns: int = 0

    def __post_init__(self) -> None:
        _named(self.by, "unlock")
        if self.unlocked and not self.reason.strip():
            raise Refused("reason of the unlock", "empty", "a sentence", "say why")


@dataclass(frozen=True, slots=True, kw_only=True)
class DayLimits:
    """Limits measured on a patient; they hold for that day and wrist angle only.

    Attributes:
        id: Number in the catalogue, 0 before it is added.
        patient: Pseudonym.
        side: Side of the hand on which they were measured.
        device: Device in which they were measured.
        wrist_rad: Wrist extension at which they were measured.
        content: The limits, JSON.
        measured_utc_ns: When they were measured.
        expires_utc_ns: When they cease to hold.
        by: Who measured.
    """

    id: int = 0
    patient: str
    side: Side
    device: str
    wrist_rad: float
    content: str
    measured_utc_ns: int
    expires_utc_ns: int
    by: str

    def __post_init__(self) -> None:
        if self.side not in SIDES:
            raise Refused("side of the limits", repr(self.side), "left or right", "measure again")
        if not math.isfinite(self.wrist_rad):
            raise Refused("wrist angle", f"{self.wrist_rad} rad", "a finite angle", "measure it")
        if not 0 < self.measured_utc_ns < self.expires_utc_ns:
            raise Refused("limits", "expired when measured", "valid for some time", "correct the clock")
        _named(self.by, "limits")


@dataclass(frozen=True, slots=True, kw_only=True)
class LimitChange:
    """One limit of one joint, set by a person; the newest that has not expired counts.

    Attributes:
        id: Number in the catalogue, 0 before it is added.
        patient: Pseudonym.
        device: Device for which it holds.
        joint: Name of the driven joint.
        limit: Which limit, one of CHANGEABLE.
        value: New value, in the unit of its name.
        expires_utc_ns: When it ceases to hold; 0 for never, as of a limit that was made safer.
        reason: Why.
        by: Who.
        created_utc_ns: When.
    """

    id: int = 0
    patient: str
    device: str
    joint: str
    limit: str
    value: float
    expires_utc_ns: int = 0
    reason: str = ""
    by: str
    created_utc_ns: int = 0

    def __post_init__(self) -> None:
        if self.limit not in CHANGEABLE:
            raise Refused("limit", repr(self.limit), "one of " + ", ".join(CHANGEABLE), "choose one")
        if not math.isfinite(self.value):
            raise Refused(f"limit of {self.joint}", f"{self.value}", "a finite number", "type a number")
        _named(self.by, "limit")


@dataclass(frozen=True, slots=True, kw_only=True)
class LimitsRead:
    """On what somebody stands who changes limits of a patient in a device.

    Attributes:
        change: Number of the newest limit that was set there, 0 where none was.
        record: Number of the newest clinical record, 0 where none was stated.
    """

    change: int
    record: int


@dataclass(frozen=True, slots=True, kw_only=True)
class AssistanceMemory:
    """Assistance that a session ended with, where the next one of the same exercise begins.

    Attributes:
        id: Number in the catalogue, 0 before it is added.
        patient: Pseudonym.
        exercise: Exercise name.
        device: Device.
        content: JSON: stiffness multiples by digit, a row for extension and one for flexion.
        session: Id of the session.
        created_utc_ns: When it was added.
    """

    id: int = 0
    patient: str
    exercise: str
    device: str
    content: str
    session: str
    created_utc_ns: int = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class FitCheck:
    """How a device sat on a patient's hand; the last good one is what the next is compared with.

    Attributes:
        id: Number in the catalogue, 0 before it is added.
        patient: Pseudonym.
        side: Side of the hand.
        device: Device.
        content: JSON of what was found, by joint.
        verdict: Empty where it fitted, else the sentence that says what did not.
        session: Id of the session.
        by: Who checked.
        created_utc_ns: When it was added.
    """

    id: int = 0
    patient: str
    side: Side
    device: str
    content: str
    verdict: str
    session: str
    by: str
    created_utc_ns: int = 0

    def __post_init__(self) -> None:
        if self.side not in SIDES:
            raise Refused("side of the fit check", repr(self.side), "left or right", "check the fit again")
        _named(self.by, "fit check")


def _named(by: str, thing: str) -> None:
    """Refuse what nobody answers for.

    Raises:
        Refused: Nobody is named.
    """
    if not by.strip():
        raise Refused(f"author of the {thing}", "nobody", "a named user", "name who does it")
