"""A take without its images, as a file of its own: for whoever withdraws the consent to them."""

from __future__ import annotations

import heapq
import math
import uuid
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

from sessions.errors import Refused
from sessions.records import Event, Topic
from sessions.records.topics import EVENTS, TOPICS
from sessions.store import SealedSession, SessionReader, SessionWriter, verify
from sessions.store.recordtimes import times_of


def has_images(path: Path) -> bool:
    """Whether a sealed file holds images.

    Raises:
        Refused: It is damaged.
    """
    with SessionReader(path) as reader:
        counts = reader.counts
        return any(counts.get(topic.name, 0) for topic in TOPICS.values() if topic.needs_consent)


def write_without_images(parent: Path, out: Path, author: str, software_version: str) -> SealedSession:
    """Copy every record of a file but its images.

    Args:
        parent: Sealed file; it is only read.
        out: The new file; must not exist.
        author: Account of who does it.
        software_version: Of this application.

    Raises:
        Refused: The parent is damaged, or the new file cannot be written. No file is left then.
    """
    digest = verify(parent).sha256
    with SessionReader(parent) as reader:
        header = replace(
            reader.header,
            session_id=uuid.uuid4().hex,
            consent_images=False,
            parents=(digest,),
            software_version=software_version,
        )
        kept = [topic for topic in TOPICS.values() if not topic.needs_consent]
        try:
            with SessionWriter(out, header) as writer:
                for _, _, topic, record in heapq.merge(*(_timed(reader, topic) for topic in kept)):
                    writer.write(topic, record)
                writer.write(EVENTS, _note(header.monotonic_start_ns, author))
                return writer.seal()
        except (Refused, OSError):
            out.unlink(missing_ok=True)
            raise


def _timed(reader: SessionReader, topic: Topic) -> Iterator[tuple[int, str, Topic, Any]]:
    """Records with what orders them; the name of the topic keeps records of one time apart."""
    for number, record in enumerate(reader.records(topic)):
        yield times_of(topic, record)[1], f"{topic.name} {number:012d}", topic, record


def _note(t_ns: int, author: str) -> Event:
    said = f"Images were left out of this copy by {author}: the consent was withdrawn."
    return Event(
        t_ns=t_ns,
        kind="note",
        severity="info",
        cause="images-removed",
        category="",
        subject="",
        value=math.nan,
        bound=math.nan,
        text=said,
    )
