"""Reading a sealed session: typed records or whole columns, by topic and time, through the index."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from pathlib import Path
from types import TracebackType
from typing import Any

from mcap.opcode import Opcode
from mcap.records import Channel, ChunkIndex

from sessions.errors import Refused
from sessions.records import TOPICS, Event, SessionHeader, Topic
from sessions.records.topics import EVENTS
from sessions.store import refusals
from sessions.store.codec import TableCodec, codec_for
from sessions.store.columns import Columns, gather, stack
from sessions.store.container import MAGIC, RawMessage, Source, attachment
from sessions.store.damage import Damaged
from sessions.store.foreign import describe, session_texts_at_start
from sessions.store.header import METADATA_NAME, header_from_texts
from sessions.store.overview import ATTACHMENT_NAME, Overview, decode_overview
from sessions.store.recordtimes import BLOCK_SPAN_MAX_NS
from sessions.store.summary import (
    Summary,
    Unsealed,
    indexed_messages,
    indexed_span,
    read_chunk,
    read_metadata,
    read_summary,
)
from sessions.timebase import Timebase


class SessionReader:
    """Reads one sealed session file; a context manager.

    Args:
        path: The file.
        source: Where its bytes come from when they do not lie at ``path``; closed with the reader.

    Attributes:
        path: The file.
        header: Who, what, when.
        summary: The index.

    Raises:
        Refused: The file is no sealed session: absent, empty, no MCAP, cut, damaged, foreign or too new.
    """

    def __init__(self, path: Path, source: Source | None = None) -> None:
        self.path = path
        with refusals.refusing(path):
            self._source = Source(path) if source is None else source
        try:
            with refusals.refusing(path):
                self.summary, self.header = _opened(path, self._source)
        except Refused:
            self._source.close()
            raise
        self._timebase = Timebase(self.header.utc_start_ns, self.header.monotonic_start_ns)

    def __enter__(self) -> SessionReader:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._source.close()

    @property
    def counts(self) -> dict[str, int]:
        """How many records each topic holds, by topic name."""
        by_channel = self.summary.statistics[0].channel_message_counts if self.summary.statistics else {}
        counts: dict[str, int] = {}
        for channel in self.summary.channels.values():
            counts[channel.topic] = counts.get(channel.topic, 0) + by_channel.get(channel.id, 0)
        return counts

    def span_ns(self) -> tuple[int, int] | None:
        """First and last time that is filed, monotonic in ns; None of a session without records."""
        if not self.summary.statistics or not self.summary.statistics[0].message_count:
            return None
        statistics = self.summary.statistics[0]
        to_monotonic = self._timebase.to_monotonic_ns
        return to_monotonic(statistics.message_start_time), to_monotonic(statistics.message_end_time)

    def records(self, topic: Topic, start_ns: int | None = None, end_ns: int | None = None) -> Iterator[Any]:
        """Records of a topic in the order written, each of type ``topic.record``.

        Args:
            topic: Which stream; one that the file lacks gives nothing.
            start_ns: From this monotonic time on; a block that reaches into the range comes whole.
            end_ns: Before this monotonic time.

        Raises:
            Refused: The file is damaged, or the topic is in a newer layout.
        """
        codec = codec_for(topic)
        with refusals.refusing(self.path):
            for chunk in self._messages(topic, start_ns, end_ns):
                for message in chunk:
                    yield codec.decode(message.data, self._timebase.to_monotonic_ns(message.log_time))

    def columns(
        self,
        topic: Topic,
        start_ns: int | None = None,
        end_ns: int | None = None,
        names: Collection[str] | None = None,
    ) -> Columns:
        """A topic as arrays by field name.

        Args:
            topic: Which stream; one that the file lacks gives empty arrays.
            start_ns: Rows from this monotonic time on.
            end_ns: Rows before this monotonic time.
            names: Only these fields (and ``t_ns``), which is faster; None for all.

        Raises:
            Refused: The file is damaged, a name is no field, or the records differ in shape.
        """
        _check_names(topic, names)
        codec = codec_for(topic)
        if not isinstance(codec, TableCodec):
            return stack(topic, self.records(topic, start_ns, end_ns), names)
        with refusals.refusing(self.path):
            chunks = self._messages(topic, start_ns, end_ns)
            return gather(topic, codec, chunks, names).between(start_ns, end_ns)

    def events(self) -> tuple[Event, ...]:
        """All events, in the order written.

        Raises:
            Refused: The file is damaged.
        """
        return tuple(self.records(EVENTS))

    def overview(self) -> Overview | None:
        """The session at a glance, without reading its chunks; None where the file has none.

        Raises:
            Refused: The file is damaged.
        """
        with refusals.refusing(self.path):
            for index in self.summary.attachments:
                if index.name == ATTACHMENT_NAME:
                    span = indexed_span(self._source, index.offset, index.length, Opcode.ATTACHMENT)
                    return decode_overview(attachment(self._source, span).data)
        return None

    def metadata(self, name: str) -> dict[str, str] | None:
        """The texts of another metadata record, such as ``recovery``; None where the file has none."""
        with refusals.refusing(self.path):
            for index in self.summary.metadata:
                if index.name == name:
                    return read_metadata(self._source, index)
        return None

    def unpacked(self) -> Iterator[memoryview]:
        """The records inside every chunk, unpacked and proven, in the order of the file.

        Raises:
            Damaged: A chunk is not where or what the index says, or fails its CRC.
        """
        return (read_chunk(self._source, index) for index in self.summary.chunks)

    def _messages(self, topic: Topic, start_ns: int | None, end_ns: int | None) -> Iterator[list[RawMessage]]:
        """The messages of a topic that may reach into a time range, chunk by chunk."""
        channels = {item.id for item in self.summary.channels.values() if item.topic == topic.name}
        for channel_id in channels:
            check_channel(self.summary.channels[channel_id], topic, self.summary)
        to_utc = self._timebase.to_utc_ns
        start = 0 if start_ns is None else to_utc(start_ns)
        end = 2**64 if end_ns is None else to_utc(end_ns)
        for index in self.summary.chunks:
            if _may_hold(index, channels, start, end):
                found = indexed_messages(read_chunk(self._source, index), channels)
                yield [item for item in found if item.log_time >= start and item.publish_time < end]


def check_channel(channel: Channel, topic: Topic, summary: Summary) -> None:
    """Refuse a channel whose messages this program cannot read.

    Raises:
        Refused: Its layout is newer.
        Damaged: It claims another schema or encoding than the topic has.
    """
    version = channel.metadata.get("version", "")
    if version.isascii() and version.isdigit() and len(version) < 9 and int(version) > topic.version:
        remedy = "open the file with a newer rehab-app"
        raise Refused(f"layout version of {topic.name}", version, f"at most {topic.version}", remedy)
    schema = summary.schemas.get(channel.schema_id)
    if schema is None or schema.name != topic.schema or channel.message_encoding != "protobuf":
        raise Damaged(f"{topic.name} is not in the schema {topic.schema}")


def _may_hold(index: ChunkIndex, channels: set[int], start: int, end: int) -> bool:
    if index.message_end_time < start or index.message_start_time - BLOCK_SPAN_MAX_NS >= end:
        return False
    return not index.message_index_offsets or not channels.isdisjoint(index.message_index_offsets)


def _check_names(topic: Topic, names: Collection[str] | None) -> None:
    from_file = TOPICS.get(topic.name, topic)
    known = set(from_file.record.__dataclass_fields__)
    unknown = sorted(set(names or ()) - known)
    if unknown:
        raise Refused(
            f"field of {topic.name}", unknown[0], f"one of {', '.join(sorted(known))}", "choose one"
        )


def _opened(path: Path, source: Source) -> tuple[Summary, SessionHeader]:
    if source.size == 0:
        raise refusals.empty(path)
    start = source.read(0, min(source.size, len(MAGIC)))
    if start != MAGIC:
        raise refusals.cut(path) if MAGIC.startswith(start) else refusals.no_mcap(path, start)
    try:
        summary = read_summary(source)
    except Unsealed:
        if session_texts_at_start(source) is None:
            raise refusals.foreign(path, describe(source)) from None
        raise refusals.cut(path) from None
    for index in summary.metadata:
        if index.name == METADATA_NAME:
            return summary, header_from_texts(read_metadata(source, index))
    raise refusals.foreign(path, describe(source))
