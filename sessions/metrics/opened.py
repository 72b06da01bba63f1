"""A sealed file as the metrics need it: the reader's columns, and the digest of the bytes on disk."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from sessions.metrics.measure import measure
from sessions.metrics.separated import PassiveRun, read_passive
from sessions.metrics.summary import Summary
from sessions.records import SessionHeader, Topic
from sessions.store import SessionReader


@dataclass(frozen=True, slots=True)
class OpenedFile:
    """A ``Recording`` over an open reader.

    Attributes:
        reader: The open file.
        sha256: Digest of its bytes, computed now and not taken from a note beside it.
    """

    reader: SessionReader
    sha256: str

    @property
    def header(self) -> SessionHeader:
        """Who, what, when."""
        return self.reader.header

    @property
    def counts(self) -> Mapping[str, int]:
        """Number of messages by topic name."""
        return self.reader.counts

    def columns(self, topic: Topic) -> Mapping[str, NDArray[Any]]:
        """Columns of one topic by field name."""
        return self.reader.columns(topic)


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
        with SessionReader(passive) as reader:
            run = read_passive(OpenedFile(reader, _digest(passive)))
    with SessionReader(path) as reader:
        return measure(OpenedFile(reader, _digest(path)), run)


def _digest(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
