"""Folds the robot's ticks, window by window, into what is kept of each repetition.

At 1 kHz the columns of half an hour take a gigabyte. Here ticks are held only until their repetition is over;
then sums, extremes and a track of 10 ms steps stay. How the windows are cut changes no number.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from sessions.metrics.recording import ACTIVE_PHASES, Recording
from sessions.metrics.robot_stretch import Stretch, stretch
from sessions.records import Topic
from sessions.records.fields import Float64, Int64
from sessions.records.topics import PHASE, ROBOT_COMMAND, ROBOT_STATE

FIELDS: Mapping[Topic, tuple[str, ...]] = {
    PHASE: ("repetition", "phase", "mode"),
    ROBOT_STATE: ("q_rad", "dq_rad_s", "tau_interaction_nm"),
    ROBOT_COMMAND: ("stiffness_nm_rad",),
}
"""What the fold needs of a file."""
Window = Mapping[str, Mapping[str, NDArray[Any]]]


@dataclass(frozen=True, slots=True)
class Commanded:
    """Stiffness of one joint while the patient was compared with the therapist, Nm/rad."""

    least: float
    most: float
    mean: float


@dataclass(frozen=True, slots=True)
class Folded:
    """Everything that is kept of the robot's ticks.

    Attributes:
        stretches: In the order of the file.
        stiffness: By robot joint; empty where the file has no command within a repetition.
        stiffness_span_ns: Time of its first and last tick.
    """

    stretches: tuple[Stretch, ...] = ()
    stiffness: Mapping[str, Commanded] = field(default_factory=dict[str, Commanded])
    stiffness_span_ns: tuple[int, int] = (0, 0)


@runtime_checkable
class Folding(Protocol):
    """A recording that folds its own ticks while it is read."""

    def folded(self) -> Folded:
        """What its ticks leave."""
        ...


def fold(recording: Recording) -> Folded:
    """What the robot's ticks leave; nothing where the file has no phases."""
    if isinstance(recording, Folding):
        return recording.folded()
    return fold_columns(recording)


def fold_columns(recording: Recording) -> Folded:
    """The same from whole columns."""
    ticks = RobotFold(len(recording.header.robot_joints))
    held = {topic.name: recording.columns(topic) for topic in FIELDS if recording.counts.get(topic.name, 0)}
    ticks.take(held)
    return ticks.finished(recording.header.robot_joints)


@dataclass(slots=True)
class _Pending:
    """Rows of one topic whose phase is not yet known, and those of the repetition that is still open."""

    waiting: list[tuple[NDArray[Any], ...]] = field(default_factory=list[tuple[NDArray[Any], ...]])
    open: list[tuple[NDArray[Any], ...]] = field(default_factory=list[tuple[NDArray[Any], ...]])
    repetition: int = -1

    def settled(self, before_ns: int) -> list[tuple[NDArray[Any], ...]]:
        """The leading rows that are earlier than a time; the rest goes on waiting."""
        early: list[tuple[NDArray[Any], ...]] = []
        while self.waiting:
            rows = self.waiting[0]
            late = rows[0] >= before_ns
            if not bool(late.any()):
                early.append(self.waiting.pop(0))
                continue
            cut = int(np.argmax(late))
            early.append(tuple(column[:cut] for column in rows))
            self.waiting[0] = tuple(column[cut:] for column in rows)
            break
        return early


class RobotFold:
    """Takes windows in the order of the file.

    Args:
        joints: Number of robot joints J.
    """

    def __init__(self, joints: int) -> None:
        self._joints = joints
        self._phases: list[tuple[NDArray[Any], ...]] = []
        self._state, self._command = _Pending(), _Pending()
        self._stretches: list[Stretch] = []
        self._stiffness: list[tuple[Float64, Float64, Float64, int]] = []
        self._span: list[int] = []

    def take(self, window: Window) -> None:
        """Take the rows of a window, by topic name; topics may be missing."""
        phase = window.get(PHASE.name)
        if phase is not None and len(phase["t_ns"]):
            active = np.isin(np.asarray(phase["phase"], dtype=np.str_), ACTIVE_PHASES)
            repetition = np.where(active, np.asarray(phase["repetition"], dtype=np.int64), -1)
            passive = np.asarray(phase["mode"], dtype=np.str_) == "passive"
            self._phases.append((np.asarray(phase["t_ns"], dtype=np.int64), repetition, passive))
        for topic, pending in ((ROBOT_STATE, self._state), (ROBOT_COMMAND, self._command)):
            rows = window.get(topic.name)
            if rows is not None and self._joints and len(rows["t_ns"]):
                pending.waiting.append(self._columns(topic, rows))
        if self._phases:
            self._settle(int(self._phases[-1][0][-1]))

    def finished(self, joints: tuple[str, ...]) -> Folded:
        """What is left of all windows."""
        self._settle(np.iinfo(np.int64).max)
        self._close(self._state)
        self._close(self._command)
        return Folded(tuple(self._stretches), self._commanded(joints), self._ends())

    def _columns(self, topic: Topic, rows: Mapping[str, NDArray[Any]]) -> tuple[NDArray[Any], ...]:
        t_ns = np.asarray(rows["t_ns"], dtype=np.int64)
        shape = (t_ns.size, self._joints)
        return t_ns, *(np.asarray(rows[name], dtype=np.float64).reshape(shape) for name in FIELDS[topic])

    def _settle(self, before_ns: int) -> None:
        """Give the rows of which the phase is known to their repetitions."""
        if not self._phases:
            return
        self._phases = [_joined(self._phases)]
        t_phase, repetition, passive = self._phases[0]
        for pending in (self._state, self._command):
            for rows in pending.settled(before_ns):
                at = np.searchsorted(t_phase, rows[0], side="right") - 1
                known = np.maximum(at, 0)
                of = np.where(at >= 0, repetition[known], -1)
                self._sort(pending, (*rows, passive[known]), of)

    def _sort(self, pending: _Pending, rows: tuple[NDArray[Any], ...], of: Int64) -> None:
        chosen = np.flatnonzero(of >= 0)
        if not chosen.size:
            return
        edges = np.flatnonzero(np.diff(of[chosen])) + 1
        for part in np.split(chosen, edges):
            if int(of[part[0]]) != pending.repetition:
                self._close(pending)
                pending.repetition = int(of[part[0]])
            whole = int(part[-1]) - int(part[0]) + 1 == part.size
            rows_of = slice(int(part[0]), int(part[-1]) + 1) if whole else part
            pending.open.append(tuple(column[rows_of] for column in rows))

    def _close(self, pending: _Pending) -> None:
        """Keep what matters of the repetition that is over."""
        if not pending.open:
            return
        parts, pending.open = pending.open, []
        times, *measured, flags = zip(*parts, strict=True)
        t_ns, passive = np.concatenate(times), np.concatenate(flags)
        by_joint = [_by_joint(columns, t_ns.size, self._joints) for columns in measured]
        if pending is self._state:
            q, dq, tau = by_joint
            self._stretches.append(stretch(pending.repetition, t_ns, (q, dq, tau), passive))
        else:
            (stiffness,) = by_joint
            self._span += [int(t_ns[0]), int(t_ns[-1])]
            low, high = stiffness.min(axis=1), stiffness.max(axis=1)
            self._stiffness.append((low, high, stiffness.sum(axis=1), t_ns.size))

    def _commanded(self, joints: tuple[str, ...]) -> dict[str, Commanded]:
        if not self._stiffness:
            return {}
        count = sum(part[3] for part in self._stiffness)
        return {
            joint: Commanded(
                float(min(part[0][column] for part in self._stiffness)),
                float(max(part[1][column] for part in self._stiffness)),
                math.fsum(float(part[2][column]) for part in self._stiffness) / count,
            )
            for column, joint in enumerate(joints)
        }

    def _ends(self) -> tuple[int, int]:
        return (self._span[0], self._span[-1]) if self._span else (0, 0)


def _joined(parts: list[tuple[NDArray[Any], ...]]) -> tuple[NDArray[Any], ...]:
    if len(parts) == 1:
        return parts[0]
    return tuple(np.concatenate(columns) for columns in zip(*parts, strict=True))


def _by_joint(parts: Sequence[Float64], ticks: int, joints: int) -> Float64:
    """Parts (N, J) one after the other as (J, N): everything that follows runs along time."""
    result, start = np.empty((joints, ticks)), 0
    for part in parts:
        result[:, start : start + len(part)] = part.T
        start += len(part)
    return result
