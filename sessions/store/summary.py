"""The index at the end of a sealed file: where its chunks, channels, metadata and attachments lie."""

from __future__ import annotations

import struct
import zlib
from dataclasses import dataclass, field

from mcap.opcode import Opcode
from mcap.records import (
    AttachmentIndex,
    Channel,
    Chunk,
    ChunkIndex,
    Footer,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
)

from sessions.store.container import (
    MAGIC,
    PREFIX_BYTES,
    RawMessage,
    Source,
    Span,
    inner_spans,
    message_of,
    parse,
    unpack,
)
from sessions.store.damage import Damaged

_FOOTER_BYTES = 20


class Unsealed(Damaged):
    """The file does not end as a finished one does."""


@dataclass(frozen=True, slots=True)
class Summary:
    """What the index says.

    Attributes:
        schemas: By schema id.
        channels: By channel id.
        chunks: In file order.
        attachments: Attachments.
        metadata: Metadata records.
        statistics: Counts, one record at most.
    """

    schemas: dict[int, Schema] = field(default_factory=dict[int, Schema])
    channels: dict[int, Channel] = field(default_factory=dict[int, Channel])
    chunks: list[ChunkIndex] = field(default_factory=list[ChunkIndex])
    attachments: list[AttachmentIndex] = field(default_factory=list[AttachmentIndex])
    metadata: list[MetadataIndex] = field(default_factory=list[MetadataIndex])
    statistics: list[Statistics] = field(default_factory=list[Statistics])

    def take(self, opcode: int, content: bytes) -> None:
        """Note one record; kinds that the index does not need are passed over."""
        if opcode == Opcode.SCHEMA:
            schema = parse(content, Schema.read)
            self.schemas[schema.id] = schema
        elif opcode == Opcode.CHANNEL:
            channel = parse(content, Channel.read)
            self.channels[channel.id] = channel
        elif opcode == Opcode.CHUNK_INDEX:
            self.chunks.append(parse(content, ChunkIndex.read))
        elif opcode == Opcode.ATTACHMENT_INDEX:
            self.attachments.append(parse(content, AttachmentIndex.read))
        elif opcode == Opcode.METADATA_INDEX:
            self.metadata.append(parse(content, MetadataIndex.read))
        elif opcode == Opcode.STATISTICS:
            self.statistics.append(parse(content, Statistics.read))


def read_summary(source: Source) -> Summary:
    """The index of a file.

    Raises:
        Unsealed: The file has no end, or an end without an index.
        Damaged: The index contradicts itself or fails its checksum.
    """
    footer_start = source.size - PREFIX_BYTES - _FOOTER_BYTES - len(MAGIC)
    if footer_start < len(MAGIC) or source.read(source.size - len(MAGIC), len(MAGIC)) != MAGIC:
        raise Unsealed("it does not end as an MCAP file does")
    span = source.span_at(footer_start)
    if span.opcode != Opcode.FOOTER or span.length != _FOOTER_BYTES:
        raise Unsealed("it has no footer")
    footer = source.parsed(span, Footer.read)
    if footer.summary_start == 0:
        raise Unsealed("it has no index")
    if not len(MAGIC) <= footer.summary_start <= footer_start:
        raise Damaged("its footer points outside the file")
    content = source.read(footer.summary_start, footer_start - footer.summary_start)
    _check_crc(content, footer)
    summary = Summary()
    data = memoryview(content)
    for inner in inner_spans(data):
        summary.take(inner.opcode, bytes(data[inner.start : inner.start + inner.length]))
    summary.chunks.sort(key=lambda chunk: chunk.chunk_start_offset)
    return summary


def read_chunk(source: Source, index: ChunkIndex) -> memoryview:
    """The unpacked records of an indexed chunk.

    Raises:
        Damaged: It is not where or what the index says, or fails its CRC.
    """
    span = indexed_span(source, index.chunk_start_offset, index.chunk_length, Opcode.CHUNK)
    chunk = source.parsed(span, Chunk.read)
    if chunk.uncompressed_size != index.uncompressed_size:
        raise Damaged("a chunk is not as long as the index says")
    return unpack(chunk)


def read_metadata(source: Source, index: MetadataIndex) -> dict[str, str]:
    """The texts of an indexed metadata record.

    Raises:
        Damaged: It is not where or what the index says.
    """
    span = indexed_span(source, index.offset, index.length, Opcode.METADATA)
    return source.parsed(span, Metadata.read).metadata


def indexed_span(source: Source, offset: int, length: int, opcode: Opcode) -> Span:
    """The record that an index points at.

    Raises:
        Damaged: Another record lies there.
    """
    span = source.span_at(offset)
    if span.opcode != opcode or span.length + PREFIX_BYTES != length:
        raise Damaged("its index points at another record")
    return span


def indexed_messages(data: memoryview, channels: set[int]) -> list[RawMessage]:
    """The messages of some channels in an unpacked chunk, in the order written."""
    found = (message_of(data, span) for span in inner_spans(data) if span.opcode == Opcode.MESSAGE)
    return [message for message in found if message.channel_id in channels]


def _check_crc(content: bytes, footer: Footer) -> None:
    head = struct.pack(
        "<BQQQ", Opcode.FOOTER, _FOOTER_BYTES, footer.summary_start, footer.summary_offset_start
    )
    if footer.summary_crc and zlib.crc32(head, zlib.crc32(content)) != footer.summary_crc:
        raise Damaged("its index fails its checksum")
