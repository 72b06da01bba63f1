"""Cuts the messages of one topic into columns.

Messages of one topic that are equally long nearly always have their fields at the same places. The places are
found once; every further message of that length is only checked to hold the same tags and lengths there, and
its payloads are cut out without looking at it field by field. One that differs is looked at by itself.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from itertools import groupby
from math import prod
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sessions.records import Topic, columns_of
from sessions.records.fields import ROWS
from sessions.store import wire
from sessions.store.codec import TableCodec
from sessions.store.columnfields import ColumnField
from sessions.store.columns import Columns
from sessions.store.damage import Damaged
from sessions.store.schema import ROWS_FIELD

_WHOLE_BYTES = 2048
"""Messages up to this length are cut out whole, longer ones field by field."""
Place = tuple[int, int]
Fixed = tuple[int, int, bytes]


@dataclass(frozen=True, slots=True)
class _Layout:
    """Where the fields of a message of some length lie.

    Attributes:
        places: Start and end of each field's payload by field number, from the message's start.
        shapes: Shape of each wanted field's value by field number, rows first.
        fixed: Start, end and content of every stretch that is no payload.
    """

    places: Mapping[int, Place]
    shapes: Mapping[int, tuple[int, ...]]
    fixed: tuple[Fixed, ...]


class _Bytes:
    """Payloads laid end to end, in memory that is taken once where all messages are equally long."""

    def __init__(self, messages: int) -> None:
        self._messages = messages
        self._held: NDArray[np.uint8] = np.empty(0, dtype=np.uint8)
        self._used = 0

    def add(self, payloads: NDArray[np.uint8]) -> None:
        """Add the payloads of M messages, (M, B); what comes first is held as it is, if it lies together."""
        size, end = payloads.size, self._used + payloads.size
        if not self._used:
            self._held = np.ascontiguousarray(payloads).reshape(-1)
        elif end > self._held.size:
            grown = np.empty(max(end, min(payloads.shape[1] * self._messages, 4 * end)), dtype=np.uint8)
            grown[: self._used] = self._held[: self._used]
            self._held = grown
        if self._used:
            self._held[self._used : end].reshape(payloads.shape)[...] = payloads
        self._used += size

    def view(self) -> memoryview:
        """What was added."""
        return self._held[: self._used].data


class Gathering:
    """The wanted columns of one topic, while the file is read.

    Args:
        topic: Which stream.
        codec: Its layout.
        names: Fields that are wanted; None for all.
        messages: How many messages are to come, as far as known.
    """

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
        self._waiting: list[memoryview] = []
        self._rows = 0
        self._inner: dict[int, set[tuple[int, ...]]] = {number: set() for number in self._wanted}

    def add(self, messages: list[memoryview]) -> None:
        """Take messages, in their order; their memory is held until ``flush``."""
        self._waiting += messages

    def flush(self) -> None:
        """Cut out the fields of the messages that were added."""
        waiting, self._waiting = self._waiting, []
        for length, run in groupby(waiting, key=len):
            alike = list(run)
            layout = self._layouts.get(length)
            if layout is None:
                layout = self._layouts[length] = self._layout(alike[0])
            if length <= _WHOLE_BYTES:
                self._flush_short(alike, length, layout)
            elif _follow(alike, layout):
                self._cut(alike, layout)
            else:
                self._flush_singly(alike)

    def _flush_short(self, alike: list[memoryview], length: int, layout: _Layout) -> None:
        """Messages of one length, laid under each other: a field is then a stripe of columns."""
        table = np.frombuffer(b"".join(alike), dtype=np.uint8).reshape(len(alike), length)
        if not _stands(table, layout):
            self._flush_singly(alike)
            return
        for number, field in self._wanted.items():
            place = layout.places.get(number)
            if field.column.scalar == "string":
                self._texts[number] += _texts_of(table, place) or _texts(alike, place)
                continue
            stripe = table[:, place[0] : place[1]] if place else _default(field, len(alike))
            self._parts[number].add(stripe)
            self._inner[number].add(layout.shapes[number][1:])
        self._rows += self._height(layout) * len(alike)

    def _flush_singly(self, messages: list[memoryview]) -> None:
        for message in messages:
            self._cut([message], self._layout(message))

    def _height(self, layout: _Layout) -> int:
        """Rows of one message."""
        return next(iter(layout.shapes.values()))[0] if self._block else 1

    def drained(self, messages: int) -> Columns:
        """What was gathered; what comes next is gathered anew, about ``messages`` of them."""
        found = self.columns()
        self._parts = {number: _Bytes(messages) for number in self._wanted}
        self._texts = {number: [] for number in self._wanted}
        self._inner = {number: set() for number in self._wanted}
        self._rows = 0
        return found

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
        return _Layout(places, shapes, tuple(_stretches(message, free)))

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

    def _cut(self, alike: list[memoryview], layout: _Layout) -> None:
        for number, field in self._wanted.items():
            place = layout.places.get(number)
            if field.column.scalar == "string":
                self._texts[number] += _texts(alike, place)
                continue
            self._parts[number].add(_joined(alike, place) if place else _default(field, len(alike)))
            self._inner[number].add(layout.shapes[number][1:])
        self._rows += self._height(layout) * len(alike)


def _stretches(message: memoryview, free: NDArray[np.bool_]) -> Iterator[Fixed]:
    """Where bytes that are no payload lie together, and what they are."""
    edges = np.flatnonzero(np.diff(np.concatenate(([False], free, [False]))))
    for start, end in edges.reshape(-1, 2).tolist():
        yield start, end, bytes(message[start:end])


def _stands(table: NDArray[np.uint8], layout: _Layout) -> bool:
    """Whether in every message, (M, B), everything that is no payload stands where the layout has it."""
    return all(
        bool((table[:, start:end] == np.frombuffer(content, dtype=np.uint8)).all())
        for start, end, content in layout.fixed
    )


def _follow(messages: list[memoryview], layout: _Layout) -> bool:
    """The same of messages that are not laid under each other."""
    return all(
        b"".join([message[start:end] for message in messages]) == content * len(messages)
        for start, end, content in layout.fixed
    )


def _joined(messages: list[memoryview], place: Place) -> NDArray[np.uint8]:
    """Payloads of one field, (M, B)."""
    payload = b"".join([message[place[0] : place[1]] for message in messages])
    return np.frombuffer(payload, dtype=np.uint8).reshape(len(messages), place[1] - place[0])


def _default(field: ColumnField, messages: int) -> NDArray[np.uint8]:
    """What a field means that is absent from all messages, (M, B)."""
    payload = np.frombuffer(field.default_payload * messages, dtype=np.uint8)
    return payload.reshape(messages, len(field.default_payload))


def _texts_of(table: NDArray[np.uint8], place: Place | None) -> list[str]:
    """The texts of messages (M, B) that all hold the same one; none where they differ."""
    if place is None or not bool((table[:, place[0] : place[1]] == table[0, place[0] : place[1]]).all()):
        return []
    return _texts([table[0].data], place) * len(table)


def _texts(messages: list[memoryview], place: Place | None) -> list[str]:
    if place is None:
        return [""] * len(messages)
    try:
        return [str(message[place[0] : place[1]], "utf-8") for message in messages]
    except UnicodeDecodeError as error:
        raise Damaged("a text is not UTF-8") from error
