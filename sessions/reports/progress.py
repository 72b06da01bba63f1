"""Progress over sessions: what is compared with what, and what may be said of the difference."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from sessions.metrics import definition
from sessions.records import JOINTS
from sessions.reports.assessed import Tone
from sessions.reports.language import _, marked
from sessions.reports.past import Kept, Past
from sessions.reports.verdict import Bound, Change, change, comparable

PROGRESS = marked("Progress")
COMPARISON = marked("Comparison of two sessions")
LEAST_RAD = 0.0873
"""5 degrees: joints that never moved as far stand in no table."""
Importance: TypeAlias = Callable[[str, str, float], str]
"""Whether a change of a metric and subject reaches a published minimal important difference, in words."""


@dataclass(frozen=True, slots=True)
class Score:
    """A score that the clinic took itself, as a row of the clinician's table; texts are ready to be read."""

    name: str
    baseline: str
    last: str
    now: str
    change: str
    meaning: str


@dataclass(frozen=True, slots=True)
class LeftOut:
    """A session that takes no part, and why."""

    session_id: str
    utc_start_ns: int
    reason: str


@dataclass(frozen=True, slots=True)
class Beside:
    """One number of the latest session beside the norm of patients alike; SI units.

    Attributes:
        name: Metric.
        subject: Joint, digit or "whole".
        value: The patient's.
        low: 5th percentile of the norm.
        median: Its median.
        high: Its 95th percentile.
        cited: How many patients, of which age: "n = 12, this clinic, age 60-69".
        made_utc_ns: When the norm was made.
        version: Version of the metric's method.
    """

    name: str
    subject: str
    value: float
    low: float
    median: float
    high: float
    cited: str
    made_utc_ns: int
    version: str


@dataclass(frozen=True, slots=True)
class Progress:
    """What a progress report starts from; it crosses to the process that renders it.

    Attributes:
        subject_id: Pseudonym.
        side: Side of the hand.
        pasts: Sessions that were measured, oldest first.
        left_out: Sessions that take no part.
        scores: The clinic's own scores.
        pains: Time in UTC ns and pain from 0 to 10, oldest first.
        bounds: Minimal detectable change by metric, subject ("" for all) and source, of this set-up.
        ordered: Repetitions that the present plan orders, 0 without one.
        software_version: Version of the software.
        title: Heading.
        active: Range assessments, what the patient reached alone, oldest first.
        passive: The same assessments, what the device reached.
        tones: Tone assessments, oldest first.
        norms: Numbers of the latest session beside the norms of this clinic.
    """

    subject_id: str
    side: str
    pasts: tuple[Past, ...]
    left_out: tuple[LeftOut, ...]
    scores: tuple[Score, ...]
    pains: tuple[tuple[int, int], ...]
    bounds: tuple[tuple[str, str, str, float], ...]
    ordered: int
    software_version: str
    title: str = PROGRESS
    active: tuple[Past, ...] = ()
    passive: tuple[Past, ...] = ()
    tones: tuple[Tone, ...] = ()
    norms: tuple[Beside, ...] = ()

    def bound(self) -> Bound:
        """The table of bounds as a question."""
        table = {(name, subject, source): value for name, subject, source, value in self.bounds}

        def known(name: str, subject: str, source: str) -> float | None:
            return table.get((name, subject, source), table.get((name, "", source)))

        return known


@dataclass(frozen=True, slots=True)
class Line:
    """One number over the sessions.

    Attributes:
        name: Metric.
        subject: Joint, digit or "whole".
        unit: SI unit.
        baseline: In the first session that may be compared with the latest; None where that is the only one.
        last: In the one before the latest, None where there is none besides the baseline.
        now: In the latest session that has it.
        session: The latest session.
        change: Now against the baseline.
        others: How many sessions have the number but may not be compared, and why (the latest reason).
    """

    name: str
    subject: str
    unit: str
    baseline: Kept | None
    last: Kept | None
    now: Kept
    session: Past
    change: Change
    others: tuple[int, str]


def line(progress: Progress, name: str, subject: str) -> Line | None:
    """One number over the sessions, None where no session has it."""
    having = [past for past in progress.pasts if not math.isnan(past.value(name, subject))]
    if not having:
        return None
    latest = having[-1]
    reasons = [(past, comparable(past, latest, name, subject)) for past in having[:-1]]
    alike = [past for past, reason in reasons if not reason]
    refused = [reason for _past, reason in reasons if reason]
    now = latest.number(name, subject)
    assert now is not None  # it has a value
    if alike:
        judged = change(alike[0], latest, name, subject, progress.bound())
    else:
        why = refused[-1] if refused else _("measured once")
        judged = Change(math.nan, "not measurable", math.nan, why)
    return Line(
        name,
        subject,
        definition(name).unit,
        alike[0].number(name, subject) if alike else None,
        alike[-1].number(name, subject) if len(alike) > 1 else None,
        now,
        latest,
        judged,
        (len(refused), refused[-1] if refused else ""),
    )


def moved_joints(pasts: Sequence[Past]) -> tuple[str, ...]:
    """Joints that moved by at least five degrees in some session, in the order of JOINTS."""
    return tuple(
        joint for joint in JOINTS if any(past.value("range_of_motion", joint) >= LEAST_RAD for past in pasts)
    )


def leading_line(progress: Progress) -> Line | None:
    """The range that a patient is told of: of the joint with the longest series, then the largest range."""
    lines = [line(progress, "range_of_motion", joint) for joint in moved_joints(progress.pasts)]
    known = [item for item in lines if item is not None and item.now.value is not None]
    measured = [item for item in known if item.now.status.partition(":")[0] == "ok"] or known
    return max(
        measured,
        key=lambda item: (item.baseline is not None, item.session.utc_start_ns, item.now.value or 0.0),
        default=None,
    )


def total(pasts: Sequence[Past], name: str) -> float:
    """Sum over the sessions that have the number."""
    values = [past.value(name) for past in pasts]
    return sum(value for value in values if not math.isnan(value))
