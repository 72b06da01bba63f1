"""What a session file holds, and the proof that it is whole."""

from __future__ import annotations

import hashlib
import zlib
from dataclasses import dataclass
from pathlib import Path

from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, DataEnd

from sessions.records import TOPICS, SessionHeader
from sessions.store import refusals
from sessions.store.codec import codec_for
from sessions.store.container import MAGIC, PREFIX_BYTES, Source, Span, attachment, messages, unpack
from sessions.store.damage import Damaged
from sessions.store.diskfile import digest_path
from sessions.store.overview import ATTACHMENT_NAME, decode_overview
from sessions.store.reader import SessionReader, check_channel

RECOVERY_NAME = "recovery"
_SHA256_LETTERS = 64
_SIDECAR_BYTES_MAX = 4096


@dataclass(frozen=True, slots=True)
class TopicInfo:
    """One topic of a file: its name, schema and number of records."""

    name: str
    schema: str
    records: int


@dataclass(frozen=True, slots=True)
class SessionInfo:
    """What a session file holds, from its header and index alone.

    Attributes:
        path: The file.
        bytes: Its length.
        header: Who, what, when.
        duration_s: From the first to the last record.
        topics: What is recorded, by name.
        events: How many events there are.
        recovered: Whether it was restored after an interruption.
        has_overview: Whether a first look need not read the file.
        sha256: The digest noted beside it, None where none is.
    """

    path: Path
    bytes: int
    header: SessionHeader
    duration_s: float
    topics: tuple[TopicInfo, ...]
    events: int
    recovered: bool
    has_overview: bool
    sha256: str | None


@dataclass(frozen=True, slots=True)
class Verification:
    """The proof that a file is whole.

    Attributes:
        path: The file.
        bytes: Its length.
        sha256: Its digest.
        digest_noted: Whether that digest stands beside the file; without it only the inner checksums speak.
        chunks: How many chunks passed their CRC.
        records: How many records were decoded, by topic.
    """

    path: Path
    bytes: int
    sha256: str
    digest_noted: bool
    chunks: int
    records: dict[str, int]


def info(path: Path) -> SessionInfo:
    """Say what a session file holds.

    Raises:
        Refused: The file is no sealed session.
    """
    with SessionReader(path) as reader, refusals.refusing(path):
        span = reader.span_ns()
        schemas = reader.summary.schemas
        topics = tuple(
            TopicInfo(channel.topic, schemas[channel.schema_id].name, reader.counts[channel.topic])
            for channel in sorted(reader.summary.channels.values(), key=lambda item: item.topic)
            if channel.schema_id in schemas
        )
        return SessionInfo(
            path=path,
            bytes=path.stat().st_size,
            header=reader.header,
            duration_s=(span[1] - span[0]) / 1e9 if span else 0.0,
            topics=topics,
            events=reader.counts.get("/events", 0),
            recovered=any(index.name == RECOVERY_NAME for index in reader.summary.metadata),
            has_overview=any(index.name == ATTACHMENT_NAME for index in reader.summary.attachments),
            sha256=noted_digest(path),
        )


def verify(path: Path) -> Verification:
    """Prove that a session file is whole: every checksum, every record, and the digest beside it.

    Raises:
        Refused: Something does not hold; the sentence says what.
    """
    with SessionReader(path) as reader, refusals.refusing(path), Source(path) as source:
        walk = _Walk(source, reader)
        for span in source.spans():
            walk.take(span)
        walk.compare()
        noted = noted_digest(path)
        met = walk.sha256()
        if noted not in (None, met):
            raise refusals.altered(path, met, str(noted))
        return Verification(path, source.size, met, noted is not None, walk.chunks, walk.records)


def noted_digest(path: Path) -> str | None:
    """The SHA-256 that stands beside a session file, None where none is.

    Raises:
        Damaged: The file beside it holds no SHA-256.
    """
    sidecar = digest_path(path)
    if not sidecar.is_file():
        return None
    with sidecar.open("rb") as file:
        words = file.read(_SIDECAR_BYTES_MAX).split()
    if not words or len(words[0]) != _SHA256_LETTERS or words[0].strip(b"0123456789abcdef"):
        raise Damaged(f"{sidecar.name} holds no SHA-256")
    return words[0].decode("ascii")


class _Walk:
    """One pass over all records of a file, proving each."""

    def __init__(self, source: Source, reader: SessionReader) -> None:
        self._source = source
        self._reader = reader
        self._crc = zlib.crc32(MAGIC)
        self._hash = hashlib.sha256(source.read(0, len(MAGIC)))
        self._names = {channel.id: self._name(channel) for channel in reader.summary.channels.values()}
        self._in_data = True
        self.chunks = 0
        self.records: dict[str, int] = {}

    def take(self, span: Span) -> None:
        content = self._source.read(span.start - PREFIX_BYTES, span.length + PREFIX_BYTES)
        self._hash.update(content)
        if span.opcode == Opcode.DATA_END:
            self._check_data_end(span)
        elif span.opcode == Opcode.CHUNK:
            self._check_chunk(span)
        elif span.opcode == Opcode.ATTACHMENT:
            item = attachment(self._source, span)
            if item.name == ATTACHMENT_NAME:
                decode_overview(item.data)
        self._crc = zlib.crc32(content, self._crc) if self._in_data else self._crc

    def compare(self) -> None:
        """Compare what was met with what the index promises."""
        if self._in_data:
            raise Damaged("its data do not end")
        promised = {topic: count for topic, count in self._reader.counts.items() if count}
        if self.records != promised or self.chunks != len(self._reader.summary.chunks):
            raise Damaged("its index does not count what it holds")

    def sha256(self) -> str:
        """Digest of the whole file; the closing magic is what lies behind the footer."""
        self._hash.update(self._source.read(self._source.size - len(MAGIC), len(MAGIC)))
        return self._hash.hexdigest()

    def _name(self, channel: Channel) -> str:
        topic = TOPICS.get(channel.topic)
        if topic is not None:
            check_channel(channel, topic, self._reader.summary)
        return channel.topic

    def _check_chunk(self, span: Span) -> None:
        self.chunks += 1
        for message in messages(unpack(self._source.parsed(span, Chunk.read))):
            name = self._names.get(message.channel_id)
            if name is None:
                raise Damaged("a record is on a channel that is not declared")
            if name in TOPICS:
                codec_for(TOPICS[name]).decode(message.data, 0)
            self.records[name] = self.records.get(name, 0) + 1

    def _check_data_end(self, span: Span) -> None:
        self._in_data = False
        noted = self._source.parsed(span, DataEnd.read).data_section_crc
        if noted and noted != self._crc:
            raise Damaged("its data fail their checksum")
