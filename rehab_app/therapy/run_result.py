"""What a therapy session on the robot came to, as ``play`` reports it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

from robot_iface.types import RunEnd
from sessions.errors import Refused
from sessions.metrics import Summary, measure_file
from sessions.store import SealedSession, SessionReader


@dataclass(frozen=True, slots=True)
class RepetitionResult:
    """One repetition; None is "not measurable".

    Attributes:
        index: Index from 0.
        started_by: "patient", "robot" or "".
        rmse_rad: Joint error against the reference at the same path coordinate, ramp and approach left out.
        fingertip_rmse_m: Fingertip error, likewise.
        assistance: Stiffness by digit as a multiple of the thesis gains, None for a digit not driven.
        robot_share: Part of the work that the robot did.
    """

    index: int
    started_by: str
    rmse_rad: float | None
    fingertip_rmse_m: float | None
    assistance: tuple[float | None, ...]
    robot_share: float | None


@dataclass(frozen=True, slots=True)
class StopResult:
    """One stop.

    Attributes:
        t_s: Time from the start of the session.
        cause: Stable code, such as "e-stop".
        category: Supervisor state entered.
    """

    t_s: float
    cause: str
    category: str


@dataclass(frozen=True, slots=True)
class PlayResult:
    """A sealed therapy session.

    Attributes:
        session: Catalogue id, "" before it is entered.
        path: The file.
        sha256: Its digest.
        mode: Therapy mode.
        repetitions: Repetitions that were begun.
        rmse_rad: Joint error over all of them.
        fingertip_rmse_m: Fingertip error over all of them.
        stops: Stops, in order.
        digest: SHA-256 of all simulated-time messages, header left out.
        completed: Whether every repetition was made.
        safety_state: Supervisor state at the end.
        simulated_s: Time on the loop's clock.
        late_p99_ns: 99th percentile of wake-up lateness, 0 in simulated time.
        overruns: Missed ticks, 0 in simulated time.
        reason: Why it ended, see ``RunEnd.reason``.
        reversals: How often the robot went back on a load.
        assistance: Assistance reached, see ``RunEnd.assistance``.
        scheduling: What scheduling the loop had.
    """

    session: str
    path: Path
    sha256: str
    mode: str
    repetitions: tuple[RepetitionResult, ...]
    rmse_rad: float | None
    fingertip_rmse_m: float | None
    stops: tuple[StopResult, ...]
    digest: str
    completed: bool
    safety_state: str
    simulated_s: float
    late_p99_ns: int
    overruns: int
    reason: str = ""
    reversals: int = 0
    assistance: tuple[tuple[float, ...], ...] = ()
    scheduling: str = ""


def result_of(sealed: SealedSession, mode: str, end: RunEnd, *, worn: bool = True) -> PlayResult:
    """Measure a sealed session; the formulas are those of its report.

    Args:
        sealed: The session file.
        mode: Therapy mode.
        end: How the run ended.
        worn: Whether a patient's hand is in the device; nobody shares the work of one that is not worn.
    """
    try:
        summary = measure_file(sealed.path)
    except Refused:  # stopped so early that there is nothing to measure
        summary = None
    return PlayResult(
        session="",
        path=sealed.path,
        sha256=sealed.sha256,
        mode=mode,
        repetitions=() if summary is None else _repetitions(summary, worn=worn),
        rmse_rad=_whole(summary, "joint_rmse"),
        fingertip_rmse_m=_whole(summary, "fingertip_rmse"),
        stops=_stops(sealed.path),
        digest=end.digest,
        completed=end.completed,
        safety_state=end.state.name,
        simulated_s=end.simulated_s,
        late_p99_ns=end.late_p99_ns,
        overruns=end.overruns,
        reason=end.reason,
        reversals=end.reversals,
        assistance=end.assistance,
        scheduling=end.scheduling,
    )


def _repetitions(summary: Summary, *, worn: bool) -> tuple[RepetitionResult, ...]:
    return tuple(
        RepetitionResult(
            index=item.index,
            started_by=item.started_by,
            rmse_rad=_known(item.rmse_rad),
            fingertip_rmse_m=_known(item.fingertip_rmse_m),
            assistance=tuple(_known(value) for value in item.assistance),
            robot_share=_known(item.robot_share) if worn else None,
        )
        for item in summary.repetitions
    )


def _stops(path: Path) -> tuple[StopResult, ...]:
    """Stops by the file's own events, also where nothing else can be measured."""
    with SessionReader(path) as reader:
        span = reader.span_ns() or (0, 0)
        return tuple(
            StopResult((event.t_ns - span[0]) / 1e9, event.cause, event.category)
            for event in reader.events()
            if event.kind == "stop"
        )


def _whole(summary: Summary | None, name: str) -> float | None:
    found = None if summary is None else summary.metric(name)
    return None if found is None else _known(found.value)


def _known(value: float) -> float | None:
    return value if math.isfinite(value) else None
