"""A sealed file as the metrics need it, read in two passes: light topics together, then the robot's ticks."""

from __future__ import annotations

import hashlib
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from sessions.metrics import Summary, measure
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
from sessions.store.bulk import columns_together

Names = Mapping[Topic, Collection[str] | None]
_LIGHT: Names = {
    HAND_POSE: None,
    MARKERS: ("status",),
    PATIENT_POSE: None,
    REFERENCE: None,
    PHASE: None,
    EVENTS: None,
    ROBOT_COMMAND: ("stiffness_nm_rad",),
}
_HEAVY: Names = {ROBOT_STATE: ("q_rad", "dq_rad_s", "tau_interaction_nm")}
_DROPPED = (ROBOT_COMMAND.name, ROBOT_STATE.name)
"""At 1 kHz a column of half an hour takes 130 MB: these are handed out once and not kept."""


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
class RecordedFile:
    """A ``Recording`` over an open reader.

    Attributes:
        reader: The open file.
        sha256: Digest of its bytes, computed now and not taken from a note beside it.
    """

    reader: SessionReader
    sha256: str
    _read: dict[str, Mapping[str, NDArray[Any]]] = field(
        default_factory=dict[str, Mapping[str, NDArray[Any]]]
    )

    @property
    def header(self) -> SessionHeader:
        """Who, what, when."""
        return self.reader.header

    @property
    def counts(self) -> Mapping[str, int]:
        """Number of messages by topic name."""
        return self.reader.counts

    def columns(self, topic: Topic) -> Mapping[str, NDArray[Any]]:
        """Columns of one topic by field name, first axis time."""
        if topic.name not in self._read:
            group = next((names for names in (_LIGHT, _HEAVY) if topic in names), None)
            if group is None or not self.counts.get(topic.name, 0):
                return self.reader.columns(topic)
            wanted = {one: names for one, names in group.items() if one.name not in self._read}
            self._read |= columns_together(self.reader, wanted)
        take = self._read.pop if topic.name in _DROPPED else self._read.__getitem__
        return _Named(self.reader, topic, take(topic.name))


def measure_recorded(path: Path) -> Summary:
    """All numbers of a sealed take or therapy session; the same as ``sessions.metrics.measure_file``, sooner.

    Args:
        path: The file.

    Raises:
        Refused: It cannot be read, or lacks what its kind needs.
    """
    with SessionReader(path) as reader:
        with path.open("rb") as file:
            digest = hashlib.file_digest(file, "sha256").hexdigest()
        return measure(RecordedFile(reader, digest))
