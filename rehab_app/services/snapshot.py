"""What the live page draws: one immutable picture of the live state machine."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

from rehab_app.services.grip_finder import NO_GRIP, FoundGrip
from robot_iface.kinematics import HandGeometry, average_hand
from sessions.records import Side
from sessions.records.fields import Float64

LiveState: TypeAlias = Literal[
    "idle",
    "countdown",
    "recording",
    "processing",
    "rehearsing",
    "playing",
    "stopped",
    "done",
    "failed",
]
WorkKind: TypeAlias = Literal["", "therapy", "range", "fit", "tone", "tracking"]
ALONG: frozenset[WorkKind] = frozenset(("therapy", "tracking"))
"""Runs along the path of a take."""
BUSY: frozenset[LiveState] = frozenset(("countdown", "recording", "processing", "rehearsing", "playing"))
_AVERAGE = average_hand()


@dataclass(frozen=True, slots=True, kw_only=True)
class LiveSnapshot:
    """One instant of the live desk. Arrays are never written after construction.

    Attributes:
        state: Where the desk stands. "stopped" is latched until ``clear_stop``.
        message: One sentence for the screen.
        patient_id: Pseudonym of the patient in therapy, "" otherwise.
        take_id: Take being played, or the one just recorded.
        session_id: Session just sealed, "" before.
        t_s: Time since the activity began.
        frame: Counts new pictures; unchanged means nothing new was measured (the page shows STALE).
        therapist_joints_rad: Reference, shape (21,), or None.
        patient_joints_rad: The measured hand, shape (21,), or None. While recording this is None and the
            therapist's hand is in ``therapist_joints_rad``.
        geometry: Hand of whoever is drawn.
        side: Side of that hand.
        fingertip_error_m: Distance of each fingertip from the reference, shape (5,); None outside the
            compared movement.
        phase: One of ``robot_iface.runtime.live.PHASES``.
        repetition: Index of the repetition, in a range sweep of the posture, from 0; -1 outside one.
        repetitions: How many there are, 0 where nothing is counted.
        started_by: patient, robot or "".
        support: Mean stiffness as a multiple of the thesis gains, None outside therapy.
        interaction_nm: Largest torque between robot and patient now, None outside therapy.
        safety_state: Supervisor state's name, "" outside therapy.
        tracking_quality: Share of markers measured (0 to 1), None outside recording.
        estimated_share: Share of markers that was only estimated in the last second of a recording.
        lost_share: Share of markers that was lost in the last second of a recording.
        dropped: Captures that the camera lost in this recording.
        countdown_s: Seconds left before recording, 0 otherwise.
        paused: Whether the path is held.
        stop_source: Who pressed stop; "" while it is not pressed.
        speed: Path speed asked for, 0 outside therapy.
        grip: The target grip that is shown beside the hands.
        kind: What is run: therapy or tracking along a take, a sweep, the fit check; "" outside a run.
        device: The robot that moves, "" outside a run.
        worn: Whether the patient wears it.
        mode: Therapy mode, "" outside therapy.
        reversing: Whether the movement goes back, or has gone back, at a person's wish.
        notes: What happened in this run, newest last, one sentence each.
        late_p99_ns: 99th percentile of how late the control loop's ticks began.
        overruns: Ticks that missed their deadline.
    """

    state: LiveState = "idle"
    message: str = "Ready."
    patient_id: str = ""
    take_id: str = ""
    session_id: str = ""
    t_s: float = 0.0
    frame: int = 0
    therapist_joints_rad: Float64 | None = None
    patient_joints_rad: Float64 | None = None
    geometry: HandGeometry = _AVERAGE
    side: Side = "right"
    fingertip_error_m: Float64 | None = None
    phase: str = ""
    repetition: int = -1
    repetitions: int = 0
    started_by: str = ""
    support: float | None = None
    interaction_nm: float | None = None
    safety_state: str = ""
    tracking_quality: float | None = None
    estimated_share: float = 0.0
    lost_share: float = 0.0
    dropped: int = 0
    countdown_s: float = 0.0
    paused: bool = False
    stop_source: str = ""
    speed: float = 0.0
    grip: FoundGrip = NO_GRIP
    kind: WorkKind = ""
    device: str = ""
    worn: bool = True
    mode: str = ""
    reversing: bool = False
    notes: tuple[str, ...] = ()
    late_p99_ns: int = 0
    overruns: int = 0
