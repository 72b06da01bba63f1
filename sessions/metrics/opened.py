"""A sealed file as the metrics need it: read in one pass, in which the robot's ticks are folded, not kept."""

from __future__ import annotations

import hashlib
from collections.abc import Generator, Iterator, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from sessions.metrics.measure import measure
from sessions.metrics.robot_fold import FIELDS, Folded, RobotFold
from sessions.metrics.separated import PassiveRun, read_passive
from sessions.metrics.summary import Summary
from sessions.records import SessionHeader, Topic
from sessions.records.topics import (
    EVENTS,
    HAND_POSE,
    MARKERS,
    PATIENT_POSE,
    PHASE,
    REFERENCE,
    ROBOT_COMMAND,
    ROBOT_STATE,
)
from sessions.store import SessionReader
from sessions.store.bulk import Names, columns_passing

_WHOLE: Names = {
    HAND_POSE: None,
    MARKERS: ("status",),
    PATIENT_POSE: None,
    REFERENCE: ("joints_rad", "fingertips_palm_m"),
    PHASE: None,
    EVENTS: None,
}


class _Named(Mapping[str, NDArray[Any]]):
    """Columns that were read ahead; any other column of the topic is read when somebody asks for it."""

    def __init__(self, reader: SessionReader, topic: Topic, ahead: Mapping[str, NDArray[Any]]) -> None:
        self._reader, self._topic, self._ahead = reader, topic, ahead

    def __getitem__(self, name: str) -> NDArray[Any]:
        if name in self._ahead:
            return self._ahead[name]
        return self._reader.columns(self._topic, names=(name,))[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._ahead)

    def __len__(self) -> int:
        return len(self._ahead)


@dataclass(slots=True)
class OpenedFile:
    """A ``Recording`` over an open reader.

    Attributes:
        reader: The open file.
        digest: Digest of its bytes, computed now and not taken from a note beside it.
    """

    reader: SessionReader
    digest: Future[str]
    _read: dict[str, Mapping[str, NDArray[Any]]] = field(
        default_factory=dict[str, Mapping[str, NDArray[Any]]]
    )
    _folded: Folded | None = None

    @property
    def header(self) -> SessionHeader:
        """Who, what, when."""
        return self.reader.header

    @property
    def sha256(self) -> str:
        """SHA-256 of the file, hexadecimal."""
        return self.digest.result()

    @property
    def counts(self) -> Mapping[str, int]:
        """Number of messages by topic name."""
        return self.reader.counts

    def columns(self, topic: Topic) -> Mapping[str, NDArray[Any]]:
        """Columns of one topic by field name."""
        if topic not in _WHOLE or not self.counts.get(topic.name, 0):
            return self.reader.columns(topic)
        self._pass()
        return _Named(self.reader, topic, self._read[topic.name])

    def folded(self) -> Folded:
        """What the robot's ticks leave."""
        return self._pass()

    def _pass(self) -> Folded:
        """Go through the file once."""
        if self._folded is None:
            joints = self.header.robot_joints
            robot = any(self.counts.get(topic.name, 0) for topic in (ROBOT_STATE, ROBOT_COMMAND))
            ticks = RobotFold(len(joints))
            self._read |= columns_passing(self.reader, _WHOLE, FIELDS if robot else {}, ticks.take)
            self._folded = ticks.finished(joints)
        return self._folded


def measure_file(path: Path, passive: Path | None = None) -> Summary:
    """All numbers of a sealed take or therapy session.

    Args:
        path: The file.
        passive: A passive run of the same hand, day and device, whose curve is taken off the patient's work.

    Raises:
        Refused: One of them cannot be read, or lacks what its kind needs.
    """
    run: PassiveRun | None = None
    if passive is not None:
        with _opened(passive) as recording:
            run = read_passive(recording)
    with _opened(path) as recording:
        return measure(recording, run)


@contextmanager
def _opened(path: Path) -> Generator[OpenedFile]:
    """The file, while a thread goes through its bytes for the digest."""
    with SessionReader(path) as reader, ThreadPoolExecutor(1, "digest") as pool:
        yield OpenedFile(reader, pool.submit(_digest, path))


def _digest(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
