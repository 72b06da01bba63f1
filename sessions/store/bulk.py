"""Several topics as whole columns in one pass through a file: each chunk is unpacked once.

Messages of one topic that are equally long nearly always have their fields at the same places. The places are
found once; every further message of that length is only checked to hold the same tags and lengths there, and
its payloads are cut out without looking at it field by field. One that differs is looked at by itself.
"""

from __future__ import annotations

import struct
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from itertools import groupby
from math import prod
from typing import Any

import numpy as np
from mcap.opcode import Opcode
from numpy.typing import NDArray

from sessions.records import Topic, columns_of
from sessions.records.fields import ROWS
from sessions.store import refusals, wire
from sessions.store.codec import TableCodec, codec_for
from sessions.store.columnfields import ColumnField
from sessions.store.columns import Columns
from sessions.store.container import PREFIX_BYTES
from sessions.store.damage import Damaged
from sessions.store.reader import SessionReader, check_channel
from sessions.store.schema import ROWS_FIELD

_HEAD = struct.Struct("<BQH")
"""Opcode, length and channel: what must be known of a record to pass it over."""
_MESSAGE_BYTES = 22
Place = tuple[int, int]


@dataclass(frozen=True, slots=True)
class _Layout:
    """Where the fields of a message of some length lie.

    Attributes:
        places: Start and end of each field's payload by field number, from the message's start.
        shapes: Shape of each wanted field's value by field number, rows first.
        fixed: Positions of the bytes that are no payload, shape (F,).
        expected: What stands there, shape (F,).
    """

    places: Mapping[int, Place]
    shapes: Mapping[int, tuple[int, ...]]
    fixed: NDArray[np.int64]
    expected: NDArray[np.uint8]


class _Bytes:
    """Payloads laid end to end, in memory that is taken once where all messages are equally long."""

    def __init__(self, messages: int) -> None:
        self._messages = messages
        self._held: NDArray[np.uint8] = np.empty(0, dtype=np.uint8)
        self._used = 0

    def add(self, payload: bytes, count: int) -> None:
        """Add the payloads of ``count`` messages."""
        end = self._used + len(payload)
        if end > self._held.size:
            whole = -(-len(payload) // count) * self._messages
            grown = np.empty(max(end, min(whole, 4 * end) if self._used else whole), dtype=np.uint8)
            grown[: self._used] = self._held[: self._used]
            self._held = grown
        self._held[self._used : end] = np.frombuffer(payload, dtype=np.uint8)
        self._used = end

    def view(self) -> memoryview:
        """What was added."""
        return self._held[: self._used].data


class _Gathering:
    """The wanted columns of one topic, while the file is read."""

    def __init__(self, topic: Topic, codec: TableCodec, names: Collection[str] | None, messages: int) -> None:
        self._codec = codec
        self._block = bool(columns_of(topic.record)["t_ns"].shape)
        self._wanted: dict[int, ColumnField] = {
            number: field
            for number, field in codec.fields.items()
            if names is None or field.name in names or field.name == "t_ns"
        }
        self._layouts: dict[int, _Layout] = {}
        self._parts = {number: _Bytes(messages) for number in self._wanted}
        self._texts: dict[int, list[str]] = {number: [] for number in self._wanted}
        self._rows = 0
        self._inner: dict[int, set[tuple[int, ...]]] = {number: set() for number in self._wanted}

    def take(self, data: memoryview, places: list[Place]) -> None:
        """Take the messages of one chunk, in their order."""
        seen = np.frombuffer(data, dtype=np.uint8)
        for length, run in groupby(places, key=lambda place: place[1] - place[0]):
            starts = [start for start, _ in run]
            layout = self._layouts.get(length)
            if layout is None:
                layout = self._layouts[length] = self._layout(data[starts[0] : starts[0] + length])
            at = np.array(starts, dtype=np.int64)[:, None] + layout.fixed
            same = (seen[at] == layout.expected).all(axis=1)
            if same.all():
                self._cut(data, starts, layout)
                continue
            for start in starts:
                self._cut(data, [start], self._layout(data[start : start + length]))

    def columns(self) -> Columns:
        """What was gathered; the memory of the parts is given back field by field."""
        arrays: dict[str, NDArray[Any]] = {}
        for number, field in self._wanted.items():
            if field.column.scalar == "string":
                arrays[field.name] = np.array(self._texts.pop(number), dtype=np.str_)
                continue
            inner = self._inner[number]
            if len(inner) > 1:
                raise Damaged(f"{field.name} changes its shape")
            joined = self._parts.pop(number).view()
            shape = (self._rows, *(inner.pop() if inner else self._empty(field)))
            numbers = field.elements(joined)
            if numbers.size != prod(shape):
                raise Damaged(f"{field.name} changes its length")
            arrays[field.name] = numbers.reshape(shape)
        return Columns(arrays)

    def _empty(self, field: ColumnField) -> tuple[int, ...]:
        """Shape of a row where there is none."""
        shape = tuple(0 if size == ROWS else size for size in field.column.shape)
        return shape[1:] if self._block else shape

    def _layout(self, message: memoryview) -> _Layout:
        """Find the fields of one message; what is neither payload nor unknown must be alike in the others."""
        places: dict[int, Place] = {}
        free, rows = np.ones(len(message), dtype=bool), 0
        for number, wire_type, start, end in wire.walk(message):
            if number == ROWS_FIELD and wire_type == wire.VARINT:
                rows = wire.read_varint(message, start)[0]
                continue
            field = self._codec.fields.get(number)
            if field is not None and (wire_type != field.wire_type or number in places):
                raise Damaged(f"{field.name} is not as its schema says, or occurs twice")
            places[number] = (start, end)
            free[start:end] = False
        shapes = {
            number: self._shape(number, field, message, places, rows)
            for number, field in self._wanted.items()
        }
        if self._block and len({shape[0] for shape in shapes.values()}) > 1:
            raise Damaged("the columns of a block differ in their number of ticks")
        fixed = np.flatnonzero(free)
        return _Layout(places, shapes, fixed, np.frombuffer(message, dtype=np.uint8)[fixed].copy())

    def _shape(
        self, number: int, field: ColumnField, message: memoryview, places: Mapping[int, Place], rows: int
    ) -> tuple[int, ...]:
        """Shape of the value, rows first: a message that is no block is one row."""
        if field.column.scalar == "string":
            return (1,)
        start, end = places.get(number, (0, 0))
        payload = message[start:end] if number in places else memoryview(field.default_payload)
        shape = field.record_shape(field.count(payload), rows)
        return shape if self._block else (1, *shape)

    def _cut(self, data: memoryview, starts: list[int], layout: _Layout) -> None:
        for number, field in self._wanted.items():
            place = layout.places.get(number)
            if field.column.scalar == "string":
                self._texts[number] += _texts(data, starts, place)
                continue
            first, end = place or (0, 0)
            parts = [data[start + first : start + end] for start in starts] if place else []
            joined = b"".join(parts) if place else field.default_payload * len(starts)
            self._parts[number].add(joined, len(starts))
            self._inner[number].add(layout.shapes[number][1:])
        height = next(iter(layout.shapes.values()))[0] if self._block else 1
        self._rows += height * len(starts)


def columns_together(
    reader: SessionReader, wanted: Mapping[Topic, Collection[str] | None]
) -> dict[str, Columns]:
    """Columns of several topics, in one pass.

    Args:
        reader: The open file.
        wanted: Topics in layouts of our own, with the fields that are wanted; None for all.

    Returns:
        The same as ``reader.columns`` of each, by topic name.

    Raises:
        Refused: The file is damaged, or a topic is in a newer layout.
    """
    with refusals.refusing(reader.path):
        counts = reader.counts
        gatherings = {
            topic.name: _gathering(topic, names, counts.get(topic.name, 0)) for topic, names in wanted.items()
        }
        by_channel = {
            channel.id: gatherings[channel.topic]
            for channel in reader.summary.channels.values()
            if channel.topic in gatherings
        }
        for topic in wanted:
            for channel in reader.summary.channels.values():
                if channel.topic == topic.name:
                    check_channel(channel, topic, reader.summary)
        for data in reader.unpacked():
            for channel, places in _places(data, by_channel).items():
                by_channel[channel].take(data, places)
        return {name: gathering.columns() for name, gathering in gatherings.items()}


def _gathering(topic: Topic, names: Collection[str] | None, messages: int) -> _Gathering:
    codec = codec_for(topic)
    if not isinstance(codec, TableCodec):
        raise TypeError(f"{topic.name} is in somebody else's schema")
    return _Gathering(topic, codec, names, messages)


def _places(data: memoryview, channels: Iterable[int]) -> dict[int, list[Place]]:
    """Where the messages of some channels lie in an unpacked chunk.

    Raises:
        Damaged: A record reaches beyond the chunk.
    """
    found: dict[int, list[Place]] = {channel: [] for channel in channels}
    offset, size = 0, len(data)
    while offset < size:
        if offset + PREFIX_BYTES + 2 > size:
            raise Damaged("a chunk ends within a record")
        opcode, length, channel = _HEAD.unpack_from(data, offset)
        end = offset + PREFIX_BYTES + length
        if end > size:
            raise Damaged("a chunk ends within a record")
        if opcode == Opcode.MESSAGE and channel in found:
            if length < _MESSAGE_BYTES:
                raise Damaged("a message is shorter than its head")
            found[channel].append((offset + PREFIX_BYTES + _MESSAGE_BYTES, end))
        offset = end
    return found


def _texts(data: memoryview, starts: list[int], place: Place | None) -> list[str]:
    if place is None:
        return [""] * len(starts)
    try:
        return [str(data[start + place[0] : start + place[1]], "utf-8") for start in starts]
    except UnicodeDecodeError as error:
        raise Damaged("a text is not UTF-8") from error
