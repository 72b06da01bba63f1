"""What progress needs of one past session: small enough to be kept in the catalogue by the file's digest."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import msgspec

from sessions.errors import Refused
from sessions.metrics import DEFINITIONS, Metric, Repetition, Summary
from sessions.records.topics import EVENTS
from sessions.reports.passive import measure_beside
from sessions.store import SessionReader

_SHAPE = "2"
"""Rises when what is kept changes its shape."""
_AFTER_S = 2.0
TROUBLES = {
    "pain": "pain",
    "reversal": "reversed",
    "reversals": "reversed",
    "range-narrowed": "reversed",
    "load": "blocked",
    "load-hard": "blocked",
    "interaction-limit": "blocked",
    "held-stretch": "blocked",
    "cue-relax": "opposed",
}
"""What an event of a repetition says of it, by the first word of the event's cause."""


@dataclass(frozen=True, slots=True)
class Kept:
    """One number as it is kept; ``value`` is None where it could not be had.

    Attributes:
        name: Name of the metric.
        subject: Joint, digit or "whole".
        value: SI units.
        low: Lower end of the 95 % interval, None without one.
        high: Upper end.
        status: As of ``Metric``.
        version: Version of the method.
        source: What measured it.
    """

    name: str
    subject: str
    value: float | None
    low: float | None
    high: float | None
    status: str
    version: str
    source: str


@dataclass(frozen=True, slots=True)
class Trial:
    """One repetition as the rules of progress see it.

    Attributes:
        index: Index from 0.
        completed: Whether it was moved to its end.
        started_by: "patient", "robot" or empty.
        troubles: What went against it: pain, reversed, blocked, opposed.
    """

    index: int
    completed: bool
    started_by: str
    troubles: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Past:
    """One past session.

    Attributes:
        session_id: Id in the file's header.
        sha256: Digest of the file.
        subject_id: Pseudonym in the file.
        utc_start_ns: When it began.
        side: Side of the hand.
        exercise: What was played.
        modes: Therapy modes that occurred.
        conditions: Stiffness in words, empty where unknown.
        duration_s: Length.
        prescription: JSON of what was ordered.
        stops: Causes of its stops.
        numbers: Its metrics.
        trials: Its repetitions.
        reason: Why nothing could be measured, empty where it could.
    """

    session_id: str
    sha256: str
    subject_id: str
    utc_start_ns: int
    side: str
    exercise: str
    modes: tuple[str, ...] = ()
    conditions: str = ""
    duration_s: float = 0.0
    prescription: str = ""
    stops: tuple[str, ...] = ()
    numbers: tuple[Kept, ...] = ()
    trials: tuple[Trial, ...] = ()
    reason: str = ""
    _found: dict[tuple[str, str], Kept] = field(
        init=False, default_factory=dict[tuple[str, str], Kept], compare=False, repr=False
    )

    def number(self, name: str, subject: str = "whole") -> Kept | None:
        """One number, None where the session has no such number at all."""
        if not self._found:
            self._found.update({(item.name, item.subject): item for item in self.numbers})
        return self._found.get((name, subject))

    def value(self, name: str, subject: str = "whole") -> float:
        """The number's value, NaN where there is none."""
        found = self.number(name, subject)
        return math.nan if found is None or found.value is None else found.value


def past_version() -> str:
    """Version under which pasts are kept: it changes with any metric's version."""
    named = ",".join(f"{item.name}={item.version}" for item in DEFINITIONS.values())
    return f"past-{_SHAPE}-{hashlib.sha256(named.encode()).hexdigest()[:16]}"


def measure_past(path: Path, passive: Sequence[Path] = ()) -> Past:
    """Measure a sealed session; one that has nothing to measure says why.

    Args:
        path: The file.
        passive: Passive runs of the same patient and day, the likeliest first.

    Raises:
        Refused: The file cannot be read at all.
    """
    with SessionReader(path) as reader:
        header = reader.header
        counted = reader.counts.get(EVENTS.name, 0)
        events = reader.columns(EVENTS) if counted else {}
    try:
        summary = measure_beside(path, passive)
    except Refused as refusal:
        digest = hashlib.sha256(path.read_bytes()).hexdigest()
        return Past(
            header.session_id,
            digest,
            header.subject_id,
            header.utc_start_ns,
            header.side,
            header.exercise,
            reason=str(refusal),
        )
    start_ns = _first_ns(summary)
    found = [
        (float(t_ns - start_ns) * 1e-9, str(cause))
        for t_ns, cause in zip(events.get("t_ns", ()), events.get("cause", ()), strict=True)
    ]
    return past_of(summary, found)


def past_of(summary: Summary, events: Sequence[tuple[float, str]] = ()) -> Past:
    """What is kept of a session.

    Args:
        summary: Its numbers.
        events: Time from the start of the file in s, and cause.
    """
    header = summary.header
    return Past(
        header.session_id,
        summary.sha256,
        header.subject_id,
        header.utc_start_ns,
        header.side,
        header.exercise,
        summary.modes,
        summary.conditions,
        summary.duration_s,
        header.prescription,
        tuple(stop.cause for stop in summary.stops),
        tuple(_kept(item) for item in summary.metrics),
        _trials(summary.repetitions, events),
    )


def past_to_json(past: Past) -> str:
    """As the catalogue keeps it."""
    content = {name: getattr(past, name) for name in Past.__dataclass_fields__ if not name.startswith("_")}
    return msgspec.json.encode(content).decode()


def past_from_json(text: str) -> Past:
    """The past that was kept.

    Raises:
        Refused: The text holds none.
    """
    try:
        return msgspec.json.decode(text, type=Past)
    except msgspec.DecodeError as error:
        raise Refused("kept numbers", "not readable", "what this version kept", "measure again") from error


def _first_ns(summary: Summary) -> int:
    """Time from which the summary counts: that of its first hand pose."""
    ranges = summary.named("range_of_motion")
    return ranges[0].lineage.t_start_ns if ranges else summary.header.monotonic_start_ns


def _kept(item: Metric) -> Kept:
    low, high = item.interval or (None, None)
    value = item.value if item.measurable else None
    return Kept(item.name, item.subject, value, low, high, item.status, item.version, item.lineage.source)


def _trials(repetitions: Sequence[Repetition], events: Sequence[tuple[float, str]]) -> tuple[Trial, ...]:
    """An event belongs to the last repetition that began before it, until two seconds after its end."""
    found: dict[int, list[str]] = {item.index: [] for item in repetitions}
    for t_s, cause in events:
        begun = [item for item in repetitions if item.t_start_s <= t_s]
        word = cause.partition(" ")[0]
        if begun and t_s <= begun[-1].t_end_s + _AFTER_S and word in TROUBLES:
            found[begun[-1].index].append(TROUBLES[word])
    return tuple(
        Trial(item.index, item.completed, item.started_by, tuple(dict.fromkeys(found[item.index])))
        for item in repetitions
    )
