"""Restoring what an interrupted or damaged session still holds."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mcap.opcode import Opcode
from mcap.records import Chunk

from sessions.errors import Refused
from sessions.records import TOPICS, SessionHeader, Topic
from sessions.store import refusals
from sessions.store.codec import codec_for
from sessions.store.container import MAGIC, RawMessage, Source, inner_spans, messages, unpack
from sessions.store.damage import Damaged
from sessions.store.diskfile import PARTIAL_SUFFIX, SUFFIX, is_being_written, partial_path, publish
from sessions.store.foreign import describe, session_texts_at_start
from sessions.store.header import header_from_texts
from sessions.store.integrity import RECOVERY_NAME, verify
from sessions.store.reader import SessionReader, check_channel
from sessions.store.summary import Summary, read_summary
from sessions.store.writer import SealedSession, SessionWriter
from sessions.timebase import Timebase

_RECOVERING = ".recovering"


@dataclass(frozen=True, slots=True)
class Recovery:
    """What was restored.

    Attributes:
        sealed: The new file; the old one stays as it was, unless it only lacked its final name.
        records: How many records it holds.
        lost_records: Records that were met but could not be read.
        lost_chunks: Chunks that were met but could not be read.
    """

    sealed: SealedSession
    records: int
    lost_records: int
    lost_chunks: int


def partials(folder: Path) -> tuple[Path, ...]:
    """Sessions in a folder that were never sealed and that no living process is writing."""
    found = sorted(folder.glob(f"*{PARTIAL_SUFFIX}"))
    own = f"{_RECOVERING}{PARTIAL_SUFFIX}"  # what a recovery was writing is written anew from its source
    return tuple(path for path in found if not path.name.endswith(own) and not is_being_written(path))


def recover(path: Path, out: Path | None = None) -> Recovery:
    """Write all complete records of an unsealed, cut or damaged session into a new sealed file.

    A partial session that was ended in the last step of its sealing is whole: it only gets its name. One
    that was recovered already, but not removed, is not recovered twice.

    Args:
        path: The file; it is only read.
        out: The new file; by default the final name of a partial session, else ``<stem>.recovered.mcap``.

    Raises:
        Refused: The file is whole, is being written, is no session, or the new file cannot be written.
    """
    target = _target(path) if out is None else out
    if is_being_written(path):
        raise Refused(f"file {path.name!r}", "being recorded", "at rest", "stop the recording first")
    with refusals.refusing(path), Source(path) as source:
        header = _header(path, source)
        finished = _finished(path, header, target) if out is None else None
        if finished is not None:
            return finished
        _refuse_whole(path)
        scan = _Scan(source, header)
        stem = target.name.removesuffix(SUFFIX)
        working = partial_path(target.with_name(f"{stem}{_RECOVERING}{SUFFIX}"))
        working.unlink(missing_ok=True)
        try:
            sealed, count = _rewrite(scan, header, target, working)
        except Refused:
            working.unlink(missing_ok=True)
            raise
    return Recovery(sealed, count, scan.lost_records, scan.lost_chunks)


def _finished(path: Path, header: SessionHeader, target: Path) -> Recovery | None:
    """What an interrupted seal or recovery of a partial session lacked but for its last step, else None."""
    if not path.name.endswith(PARTIAL_SUFFIX):
        return None
    made = target if target.exists() else path
    try:
        proof = verify(made)
    except Refused:
        return None
    with SessionReader(made) as reader:
        if reader.header.session_id != header.session_id:
            return None
        lost = reader.metadata(RECOVERY_NAME) or {}
    if made == path:
        publish(path, target, proof.sha256)
    return Recovery(
        SealedSession(target, proof.sha256, proof.bytes),
        sum(proof.records.values()),
        int(lost.get("lost_records", "0")),
        int(lost.get("lost_chunks", "0")),
    )


def _rewrite(scan: _Scan, header: SessionHeader, target: Path, working: Path) -> tuple[SealedSession, int]:
    """Write what a scan finds into a new file, and count it."""
    count = 0
    with SessionWriter(target, header, partial=working) as writer:
        for topic, record in scan.records():
            writer.write(topic, record)
            count += 1
        lost = {"lost_records": str(scan.lost_records), "lost_chunks": str(scan.lost_chunks)}
        writer.attach_metadata(RECOVERY_NAME, {"records": str(count)} | lost)
        return writer.seal(), count


class _Scan:
    """Reads a file from its start, passing over what is damaged, until its records end."""

    def __init__(self, source: Source, header: SessionHeader) -> None:
        self._source = source
        self._timebase = Timebase(header.utc_start_ns, header.monotonic_start_ns)
        self._known = _known(source)
        self.lost_records = 0
        self.lost_chunks = 0

    def records(self) -> Iterator[tuple[Topic, Any]]:
        for chunk in self._chunks():
            for message in chunk:
                found = self._decoded(message)
                if found is None:
                    self.lost_records += 1
                else:
                    yield found

    def _chunks(self) -> Iterator[list[RawMessage]]:
        spans = self._source.spans()
        while True:
            try:
                span = next(spans)
            except (StopIteration, Damaged):
                return  # the end of what was written
            if span.opcode != Opcode.CHUNK:
                continue
            try:
                data = unpack(self._source.parsed(span, Chunk.read))
                found = list(messages(data))
                for inner in inner_spans(data):
                    if inner.opcode != Opcode.MESSAGE:
                        content = data[inner.start : inner.start + inner.length]
                        self._known.take(inner.opcode, bytes(content))
            except Damaged:
                self.lost_chunks += 1
                continue
            yield found

    def _decoded(self, message: RawMessage) -> tuple[Topic, Any] | None:
        channel = self._known.channels.get(message.channel_id)
        topic = TOPICS.get(channel.topic) if channel else None
        if channel is None or topic is None:
            return None
        try:
            check_channel(channel, topic, self._known)
            t_ns = self._timebase.to_monotonic_ns(message.log_time)
            return topic, codec_for(topic).decode(message.data, t_ns)
        except Damaged:
            return None


def _target(path: Path) -> Path:
    if path.name.endswith(PARTIAL_SUFFIX):
        return path.with_name(path.name.removesuffix(PARTIAL_SUFFIX) + SUFFIX)
    return path.with_name(f"{path.name.removesuffix(SUFFIX)}.recovered{SUFFIX}")


def _header(path: Path, source: Source) -> SessionHeader:
    if source.size == 0:
        raise refusals.empty(path)
    start = source.read(0, min(source.size, len(MAGIC)))
    if start != MAGIC:
        raise refusals.no_mcap(path, start)
    texts = session_texts_at_start(source)
    if texts is None:
        raise refusals.foreign(path, describe(source))
    return header_from_texts(texts)


def _refuse_whole(path: Path) -> None:
    try:
        verify(path)
    except Refused:
        return
    raise Refused(f"file {path.name!r}", "whole", "unsealed, cut or damaged", "use it as it is")


def _known(source: Source) -> Summary:
    """Channels from the index where there is one: they serve when the chunk that declared them is lost."""
    try:
        return read_summary(source)
    except Damaged:
        return Summary()
