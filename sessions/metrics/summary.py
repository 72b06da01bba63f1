"""What one file says: its numbers, its repetitions and the curves that a picture needs."""

from __future__ import annotations

from dataclasses import dataclass

from sessions.metrics.metric import Metric
from sessions.records import SessionHeader
from sessions.records.fields import Float64


@dataclass(frozen=True, slots=True)
class Repetition:
    """One repetition of a therapy session; a number that cannot be had is NaN.

    Attributes:
        index: Index from 0.
        t_start_s: Start of its movement, from the start of the session.
        t_end_s: End of its movement or hold.
        started_by: "patient", "robot" or empty.
        completed: Whether it was moved to its end without a stop.
        rmse_rad: Joint error over all measured joints.
        fingertip_rmse_m: Fingertip error over all digits.
        assistance: Stiffness by digit as a multiple of the thesis gains, in the order of DIGITS.
        robot_share: Part of the work that the robot did.
    """

    index: int
    t_start_s: float
    t_end_s: float
    started_by: str
    completed: bool
    rmse_rad: float
    fingertip_rmse_m: float
    assistance: tuple[float, ...]
    robot_share: float


@dataclass(frozen=True, slots=True)
class Stop:
    """One interruption.

    Attributes:
        t_s: Time from the start of the session.
        cause: Stable code.
        category: Supervisor state or stop category.
        text: One sentence for a person.
    """

    t_s: float
    cause: str
    category: str
    text: str


@dataclass(frozen=True, slots=True)
class Curves:
    """A movement, thinned for drawing; gaps are NaN.

    Attributes:
        t_s: Times from the start of the shown part, shape (N,).
        joints_rad: Joint angles, shape (N, 21).
        fingertips_palm_m: Fingertips in the palm frame, shape (N, 5, 3).
    """

    t_s: Float64
    joints_rad: Float64
    fingertips_palm_m: Float64


@dataclass(frozen=True, slots=True)
class Overlay:
    """What the picture shows.

    Attributes:
        shown: Which part of the file, in words ("repetition 3 of 3").
        hand: The hand that was recorded.
        reference: The therapist's movement at the same times, None for a take.
    """

    shown: str
    hand: Curves
    reference: Curves | None


@dataclass(frozen=True, slots=True)
class Summary:
    """Everything that is learned from one file.

    Attributes:
        header: Header of the file.
        sha256: SHA-256 of the file.
        duration_s: From the first to the last hand pose.
        modes: Therapy modes that occurred, empty for a take.
        conditions: Stiffness at which the error was obtained, in words; empty where it is unknown.
        metrics: All numbers.
        repetitions: Repetitions of a therapy session, empty for a take.
        stops: Interruptions, in order.
        overlay: Curves for the picture.
        passive_sha256: SHA-256 of the passive run that was taken off the patient's work, empty without one.
    """

    header: SessionHeader
    sha256: str
    duration_s: float
    modes: tuple[str, ...]
    conditions: str
    metrics: tuple[Metric, ...]
    repetitions: tuple[Repetition, ...]
    stops: tuple[Stop, ...]
    overlay: Overlay
    passive_sha256: str = ""

    def metric(self, name: str, subject: str = "whole") -> Metric | None:
        """One number by name and subject, None where the file has no such number."""
        found = (item for item in self.metrics if item.name == name and item.subject == subject)
        return next(found, None)

    def named(self, name: str) -> tuple[Metric, ...]:
        """All numbers of one name, in their order."""
        return tuple(item for item in self.metrics if item.name == name)
