"""What the metrics need of an opened file, and the columns they share."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from sessions.metrics.metric import Lineage
from sessions.records import DIGITS, JOINTS, SessionHeader, Status, Topic, digit_of
from sessions.records.fields import Float64, Int64, UInt8
from sessions.records.topics import PHASE

ACTIVE_PHASES = ("move", "hold")
"""Phases in which the patient is compared with the therapist; ramp and approach are left out."""


class Recording(Protocol):
    """An opened session file; ``sessions.metrics.opened.OpenedFile`` is one."""

    @property
    def header(self) -> SessionHeader:
        """Who, what, when."""
        ...

    @property
    def sha256(self) -> str:
        """SHA-256 of the file, hexadecimal."""
        ...

    @property
    def counts(self) -> Mapping[str, int]:
        """Number of messages by topic name."""
        ...

    def columns(self, topic: Topic) -> Mapping[str, NDArray[Any]]:
        """Columns of one topic by field name, first axis time."""
        ...


@dataclass(frozen=True, slots=True)
class Origin:
    """Which file, measured by what: the part of a lineage that all numbers of a file share.

    Attributes:
        sha256: SHA-256 of the file.
        source: What measured it.
        conditions: Under which conditions, empty if none.
    """

    sha256: str
    source: str
    conditions: str = ""

    def lineage(self, topics: tuple[Topic, ...], t_ns: Int64, conditions: str = "") -> Lineage:
        """Lineage of a number made from these topics over the span of these times."""
        start, end = (int(t_ns[0]), int(t_ns[-1])) if t_ns.size else (0, 0)
        said = "; ".join(text for text in (self.conditions, conditions) if text)
        return Lineage(self.sha256, tuple(topic.name for topic in topics), start, end, self.source, said)


@dataclass(frozen=True, slots=True)
class Phases:
    """Where the session stood, ready to be looked up.

    Attributes:
        t_ns: Times, shape (N,).
        repetition: Repetition index, -1 outside one, shape (N,).
        phase: Phase names, shape (N,).
        mode: Mode names, shape (N,).
        started_by: Who started the repetition, shape (N,).
        assistance: Stiffness multiple by digit, shape (N, 5).
    """

    t_ns: Int64
    repetition: Int64
    phase: NDArray[np.str_]
    mode: NDArray[np.str_]
    started_by: NDArray[np.str_]
    assistance: Float64

    def rows_at(self, t_ns: Int64) -> Int64:
        """Phase row that holds at each time; -1 before the first."""
        rows: Int64 = np.searchsorted(self.t_ns, t_ns, side="right").astype(np.int64) - 1
        return rows

    def active_repetition(self, t_ns: Int64) -> Int64:
        """Repetition that is being moved or held at each time, -1 where none."""
        rows = self.rows_at(t_ns)
        known = np.maximum(rows, 0)
        if not self.t_ns.size:
            return np.full(t_ns.shape, -1, dtype=np.int64)
        active = (rows >= 0) & np.isin(self.phase[known], ACTIVE_PHASES)
        return np.where(active, self.repetition[known], -1)


def read_phases(recording: Recording) -> Phases:
    """The phases of a therapy session; empty where the file has none."""
    if not recording.counts.get(PHASE.name, 0):
        none = np.empty(0, dtype=np.int64)
        words = np.empty(0, dtype=np.str_)
        return Phases(none, none, words, words, words, np.empty((0, 5)))
    rows = recording.columns(PHASE)
    return Phases(
        np.asarray(rows["t_ns"], dtype=np.int64),
        np.asarray(rows["repetition"], dtype=np.int64),
        np.asarray(rows["phase"], dtype=np.str_),
        np.asarray(rows["mode"], dtype=np.str_),
        np.asarray(rows["started_by"], dtype=np.str_),
        np.asarray(rows["assistance"], dtype=np.float64),
    )


def seconds(t_ns: Int64) -> Float64:
    """Times in s from the first one."""
    return (t_ns - t_ns[0]) * 1e-9 if t_ns.size else np.empty(0)


def digit_with_all_joints(joint_status: UInt8, at_least: Status) -> NDArray[np.bool_]:
    """Rows in which every joint of a digit has at least this status, shape (N, 5), from (N, 21)."""
    good = joint_status >= int(at_least)
    columns = [[i for i, joint in enumerate(JOINTS) if digit_of(joint) == digit] for digit in DIGITS]
    return np.stack([good[:, chosen].all(axis=1) for chosen in columns], axis=1)
