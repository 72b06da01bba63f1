"""Bounded reading of MCAP records: nothing is read or allocated that the file cannot hold.

The layout is that of https://mcap.dev/spec. Every length is checked against the file before it is believed, a
chunk is unpacked only into the size it declares, and that size has a ceiling; so a hostile file costs no
more memory than ``RECORD_BYTES_MAX`` twice over.
"""

from __future__ import annotations

import os
import struct
import zlib
from collections.abc import Callable, Iterator
from io import BytesIO
from pathlib import Path
from types import TracebackType
from typing import NamedTuple, TypeVar

import zstandard
from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Chunk, Schema

from sessions.store.damage import Damaged

MAGIC = b"\x89MCAP0\r\n"
RECORD_BYTES_MAX = 64 * 1024 * 1024
PREFIX_BYTES = 9
_MESSAGE = struct.Struct("<HIQQ")
_PREFIX = struct.Struct("<BQ")
R = TypeVar("R")


class RawMessage(NamedTuple):
    """One message as it lies in a chunk; times are UTC in ns."""

    channel_id: int
    log_time: int
    publish_time: int
    data: memoryview


class Span(NamedTuple):
    """Where the content of one record lies."""

    opcode: int
    start: int
    length: int


class _StrictStream(ReadDataStream):
    """The content of one record, which never gives fewer bytes than it was asked for."""

    def __init__(self, content: bytes) -> None:
        super().__init__(BytesIO(content))
        self._left = len(content)

    def read(self, length: int) -> bytes:
        if length > self._left:
            raise Damaged("a record ends before its fields do")
        self._left -= length
        return super().read(length)


class Source:
    """A file opened for bounded reading at any place.

    Args:
        path: The file.

    Raises:
        OSError: It cannot be opened.
    """

    def __init__(self, path: Path) -> None:
        self._descriptor = os.open(path, os.O_RDONLY | os.O_CLOEXEC)
        self.size = os.fstat(self._descriptor).st_size

    def __enter__(self) -> Source:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Let go of the file; safe to call twice."""
        if self._descriptor >= 0:
            os.close(self._descriptor)
        self._descriptor = -1

    def read(self, start: int, length: int) -> bytes:
        """Exactly ``length`` bytes.

        Raises:
            Damaged: They lie outside the file, or are more than any record of a session may hold.
        """
        if start < 0 or length < 0 or start + length > self.size:
            raise Damaged("a record reaches beyond the end of the file")
        if length > RECORD_BYTES_MAX:
            raise Damaged(f"a record claims {length} bytes")
        data = self._bytes(start, length)
        if len(data) != length:
            raise Damaged("the file became shorter while it was read")
        return data

    def span_at(self, offset: int) -> Span:
        """The record that begins at an offset.

        Raises:
            Damaged: It does not lie wholly within the file.
        """
        opcode, length = _PREFIX.unpack(self.read(offset, PREFIX_BYTES))
        span = Span(opcode, offset + PREFIX_BYTES, length)
        if opcode == 0 or span.start + length > self.size:
            raise Damaged("a record reaches beyond the end of the file")
        return span

    def spans(self, offset: int = len(MAGIC)) -> Iterator[Span]:
        """All records from an offset on, to the footer.

        Raises:
            Damaged: A record does not lie wholly within the file.
        """
        while True:
            span = self.span_at(offset)
            yield span
            if span.opcode == Opcode.FOOTER:
                return
            offset = span.start + span.length

    def parsed(self, span: Span, read: Callable[[ReadDataStream], R]) -> R:
        """The record of a span, read by its type's ``read``.

        Raises:
            Damaged: Its content does not follow the format.
        """
        return parse(self.read(span.start, span.length), read)

    def _bytes(self, start: int, length: int) -> bytes:
        """Bytes that lie within the size; fewer where the file became shorter."""
        return os.pread(self._descriptor, length, start)


def parse(content: bytes, read: Callable[[ReadDataStream], R]) -> R:
    """One record from its content, read by its type's ``read``.

    Raises:
        Damaged: The content does not follow the format.
    """
    try:
        return read(_StrictStream(content))
    except UnicodeDecodeError as error:
        raise Damaged("a text is not UTF-8") from error


def unpack(chunk: Chunk) -> memoryview:
    """The records inside a chunk, unpacked and proven by their CRC.

    Raises:
        Damaged: The chunk is packed in a way we do not know, lies about its size, or fails its CRC.
    """
    if not 0 <= chunk.uncompressed_size <= RECORD_BYTES_MAX:
        raise Damaged(f"a chunk claims {chunk.uncompressed_size} bytes")
    data = _decompressed(chunk)
    if len(data) != chunk.uncompressed_size:
        raise Damaged("a chunk is not as long as it says")
    if chunk.uncompressed_crc and zlib.crc32(data) != chunk.uncompressed_crc:
        raise Damaged("a chunk fails its checksum")
    return memoryview(data)


def _decompressed(chunk: Chunk) -> bytes:
    if chunk.compression == "":
        return chunk.data
    if chunk.compression != "zstd":
        raise Damaged(f"a chunk is packed with {chunk.compression[:20]!r}, of which only zstd is known")
    try:
        # The frame's own claim decides what the library allocates, so it must agree with the chunk's.
        if zstandard.frame_content_size(chunk.data) not in (-1, chunk.uncompressed_size):
            raise Damaged("a chunk is not as long as it says")
        return zstandard.ZstdDecompressor().decompress(chunk.data, max_output_size=chunk.uncompressed_size)
    except zstandard.ZstdError as error:
        raise Damaged("a chunk cannot be unpacked") from error


def inner_spans(data: memoryview) -> Iterator[Span]:
    """The records inside an unpacked chunk.

    Raises:
        Damaged: A record reaches beyond the chunk.
    """
    offset, size = 0, len(data)
    while offset < size:
        if offset + PREFIX_BYTES > size:
            raise Damaged("a chunk ends within a record")
        opcode, length = _PREFIX.unpack_from(data, offset)
        offset += PREFIX_BYTES
        if offset + length > size:
            raise Damaged("a chunk ends within a record")
        yield Span(opcode, offset, length)
        offset += length


def message_of(data: memoryview, span: Span) -> RawMessage:
    """The message of a span inside a chunk.

    Raises:
        Damaged: It is shorter than a message's head.
    """
    if span.length < _MESSAGE.size:
        raise Damaged("a message is shorter than its head")
    channel_id, _, log_time, publish_time = _MESSAGE.unpack_from(data, span.start)
    end = span.start + span.length
    return RawMessage(channel_id, log_time, publish_time, data[span.start + _MESSAGE.size : end])


def messages(data: memoryview) -> Iterator[RawMessage]:
    """The messages inside an unpacked chunk, in the order written."""
    for span in inner_spans(data):
        if span.opcode == Opcode.MESSAGE:
            yield message_of(data, span)


def declarations(data: memoryview) -> Iterator[Channel | Schema]:
    """The channels and schemas that an unpacked chunk declares."""
    for span in inner_spans(data):
        content = data[span.start : span.start + span.length]
        if span.opcode == Opcode.CHANNEL:
            yield parse(bytes(content), Channel.read)
        elif span.opcode == Opcode.SCHEMA:
            yield parse(bytes(content), Schema.read)


def attachment(source: Source, span: Span) -> Attachment:
    """An attachment, proven by its CRC.

    Raises:
        Damaged: It does not follow the format or fails its CRC.
    """
    content = source.read(span.start, span.length)
    crc = int.from_bytes(content[-4:], "little")
    if crc and zlib.crc32(content[:-4]) != crc:
        raise Damaged("an attachment fails its checksum")
    return parse(content, Attachment.read)
