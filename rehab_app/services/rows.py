"""Values that the services hand to pages and commands."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from rehab_app.recording.recorder import RecordedTake
from robot_iface.kinematics import HandGeometry
from robot_iface.types import Plan
from sessions.records import Event, Side
from sessions.records.fields import Float64


@dataclass(frozen=True, slots=True)
class TakeRow:
    """One recorded demonstration, as a list shows it.

    Attributes:
        id: Short catalogue id.
        path: The file.
        sha256: Its digest.
        side: Side of the recorded hand.
        exercise: Exercise name.
        source: Where the motion came from.
        duration_s: Length.
        created_utc_ns: When it was recorded or imported.
        approved_by: Who approved it, None while nobody has.
        parent: Id of the take that it was retouched from, "" if none.
        author: Who retouched it, "" if nobody.
        reason: Why.
        subject: Pseudonym of the person whose hand it is, "" if unknown.
        retouch: JSON of what was done to the parent, "" if nothing.
    """

    id: str
    path: Path
    sha256: str
    side: Side
    exercise: str
    source: str
    duration_s: float
    created_utc_ns: int
    approved_by: str | None
    parent: str = ""
    author: str = ""
    reason: str = ""
    subject: str = ""
    retouch: str = ""


@dataclass(frozen=True, slots=True)
class SessionRow:
    """One therapy session, as a list shows it.

    Attributes:
        id: Short catalogue id.
        path: The file.
        sha256: Its digest.
        patient_id: Pseudonym, "" where the session had no patient of the clinic (a demonstration).
        take_id: The take that was played, "" of a guided assessment.
        mode: Therapy mode.
        started_utc_ns: When it began.
    """

    id: str
    path: Path
    sha256: str
    patient_id: str
    take_id: str
    mode: str
    started_utc_ns: int


@dataclass(frozen=True, slots=True)
class ImportedSummary:
    """What an import or a recording brought.

    Attributes:
        take: Catalogue id of the new take.
        path: Its file.
        duration_s: Length.
        landmarks: Landmarks or markers per frame.
        frames: Number of frames.
        gaps: Spans in which some landmark was not seen.
        recording: More of a recording; None of an import.
    """

    take: str
    path: Path
    duration_s: float
    landmarks: int
    frames: int
    gaps: int
    recording: RecordedTake | None = None


@dataclass(frozen=True, slots=True)
class PreparedPlan:
    """A take made playable for one patient, before rehearsal.

    Attributes:
        plan: Everything that the motion process is handed.
        budget_m: Retargeting residual by digit: how far the robot's fingertip path lies from the take's.
        notes: What was changed on the way (mirrored, clipped, slowed), each one sentence.
        geometry: The patient's hand.
        patient_id: Pseudonym, "" without a patient of the clinic.
        take_id: Catalogue id of the take; "" of a guided assessment, which plays none.
        exercise: Exercise name.
        identity: Name, birth date, side and pseudonym to be compared by a person before anything moves; for
            the screen only, never for files; "" without a patient.
        binding: Ties the plan to the patient it was made for; a plan that was changed since has another one.
    """

    plan: Plan
    budget_m: dict[str, float]
    notes: tuple[str, ...]
    geometry: HandGeometry
    patient_id: str
    take_id: str
    exercise: str
    identity: str
    binding: str


@dataclass(frozen=True, slots=True)
class Replay:
    """A recording for the review viewport, at about 50 Hz.

    Attributes:
        t_s: Time from the start, shape (N,).
        reference_joints_rad: Therapist, shape (N, 21); None for a take and for a guided assessment.
        patient_joints_rad: The recorded hand, shape (N, 21).
        fingertip_error_m: RMS over digits, shape (N,), NaN outside the compared movement; None
            without a reference.
        phases: Phase label of each row, length N; empty for a take.
        events: Safety events, notes, stops; their ``t_ns`` count from the start.
        geometry: The recorded hand.
        side: Its side.
        reference_geometry: Hand on which the reference is drawn (the patient's own for a session).
        repetitions_s: Start and end of every repetition, shape (R, 2), s.
        prescription: What the header says was prescribed, JSON; the target grip of a computed grasp is in it.
        worn: Whether a person's hand moved; else the DLR-HIT-Hand II alone.
    """

    t_s: Float64
    reference_joints_rad: Float64 | None
    patient_joints_rad: Float64
    fingertip_error_m: Float64 | None
    phases: tuple[str, ...]
    events: tuple[Event, ...]
    geometry: HandGeometry
    side: Side
    reference_geometry: HandGeometry | None = field(default=None)
    repetitions_s: Float64 = field(default_factory=lambda: np.empty((0, 2)))
    prescription: str = ""
    worn: bool = True
