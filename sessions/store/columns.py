"""Many records of one topic as arrays by field name, put together without making the records."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sessions.errors import Refused
from sessions.records import Topic, columns_of
from sessions.records.fields import ROWS, Column, Int64
from sessions.store.codec import TableCodec
from sessions.store.columnfields import ColumnField
from sessions.store.container import RawMessage
from sessions.store.damage import Damaged


class Columns(Mapping[str, NDArray[Any]]):
    """Read-only arrays by field name; the first axis of each is time.

    Scalars are stacked to (N,), arrays to (N, ...); blocks are laid end to end, so that N counts ticks.
    """

    __slots__ = ("_arrays",)

    def __init__(self, arrays: Mapping[str, NDArray[Any]]) -> None:
        self._arrays = dict(arrays)
        for array in self._arrays.values():
            array.flags.writeable = False

    def __getitem__(self, name: str) -> NDArray[Any]:
        return self._arrays[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._arrays)

    def __len__(self) -> int:
        return len(self._arrays)

    @property
    def t_ns(self) -> Int64:
        """Times (N,) of all rows, monotonic."""
        return self._arrays["t_ns"]

    @property
    def rows(self) -> int:
        """How many rows each array has."""
        return len(self.t_ns)

    def between(self, start_ns: int | None, end_ns: int | None) -> Columns:
        """The rows with ``start_ns <= t_ns < end_ns``; None leaves that side open."""
        keep = np.ones(self.rows, dtype=bool)
        if start_ns is not None:
            keep &= self.t_ns >= start_ns
        if end_ns is not None:
            keep &= self.t_ns < end_ns
        return self if keep.all() else Columns({name: array[keep] for name, array in self.items()})


class _Gathered:
    """One field's payloads over many messages."""

    def __init__(self, field: ColumnField, is_block: bool) -> None:
        self.field = field
        self._is_block = is_block
        self._default = memoryview(field.default_payload)
        self._fresh: list[memoryview] = []
        self._parts: list[bytes] = []
        self._texts: list[Any] = []
        self._shapes: dict[tuple[int, int], tuple[int, ...]] = {}
        self._met: list[tuple[int, ...]] = []

    def add(self, payloads: list[memoryview] | None, rows: int) -> None:
        column = self.field.column
        if column.scalar == "string":
            self._texts.append(self.field.decode(payloads or [], rows))
            return
        if payloads and len(payloads) > 1:
            raise Damaged(f"{self.field.name} occurs twice in a record")
        payload = payloads[0] if payloads else self._default
        self._fresh.append(payload)
        self._met.append(self._shape(payload, rows))

    def settle(self) -> None:
        """Copy what was gathered, so that the chunk it lies in can be forgotten."""
        self._parts.append(b"".join(self._fresh))
        self._fresh.clear()

    def heights(self) -> list[int]:
        return [shape[0] for shape in self._met]

    def array(self, topic: Topic) -> NDArray[Any]:
        if self.field.column.scalar == "string":
            return _text_array(self._texts, self.field, topic)
        inner = {shape[1:] if self._is_block else shape for shape in self._met}
        if len(inner) > 1:
            raise _ragged(topic, self.field.name)
        shape = inner.pop() if inner else _empty_shape(self.field.column)[1 if self._is_block else 0 :]
        numbers = self.field.elements(b"".join(self._parts))
        count = sum(self.heights()) if self._is_block else len(self._met)
        return numbers.reshape(count, *shape)

    def _shape(self, payload: memoryview, rows: int) -> tuple[int, ...]:
        if self.field.column.scalar == "uint8":
            return self.field.record_shape(self.field.count(payload), rows)
        key = (len(payload), rows)
        if key not in self._shapes:
            self._shapes[key] = self.field.record_shape(self.field.count(payload), rows)
        return self._shapes[key]


def gather(
    topic: Topic, codec: TableCodec, chunks: Iterable[list[RawMessage]], names: Collection[str] | None
) -> Columns:
    """The columns of many messages.

    Args:
        topic: Their topic.
        codec: Its codec.
        chunks: The messages, chunk by chunk.
        names: Fields wanted; None for all. ``t_ns`` comes always.

    Raises:
        Damaged: A message does not follow the schema.
        Refused: The records differ in shape, so that they make no array.
    """
    is_block = bool(columns_of(topic.record)["t_ns"].shape)
    wanted = {
        number: _Gathered(field, is_block)
        for number, field in codec.fields.items()
        if names is None or field.name in names or field.name == "t_ns"
    }
    for chunk in chunks:
        for message in chunk:
            payloads, rows = codec.payloads(message.data)
            for number, gathered in wanted.items():
                gathered.add(payloads.get(number), rows)
        for gathered in wanted.values():
            gathered.settle()
    if is_block and len({tuple(gathered.heights()) for gathered in wanted.values()}) > 1:
        raise Damaged("the columns of a block differ in their number of ticks")
    return Columns({item.field.name: item.array(topic) for item in wanted.values()})


def stack(topic: Topic, records: Iterable[Any], names: Collection[str] | None) -> Columns:
    """The columns of records that were made already; for topics in schemas of others.

    Raises:
        Refused: The records differ in shape, so that they make no array.
    """
    kept = list(records)
    arrays: dict[str, NDArray[Any]] = {}
    for name, column in columns_of(topic.record).items():
        if names is not None and name not in names and name != "t_ns":
            continue
        values = [np.asarray(getattr(record, name)) for record in kept]
        if len({value.shape for value in values}) > 1:
            raise _ragged(topic, name)
        arrays[name] = np.stack(values) if values else _nothing(column)
    return Columns(arrays)


def _nothing(column: Column) -> NDArray[Any]:
    kind = np.str_ if column.scalar == "string" else np.dtype(column.scalar)
    return np.empty((0, *_empty_shape(column)), dtype=kind)


def _empty_shape(column: Column) -> tuple[int, ...]:
    return tuple(0 if size == ROWS else size for size in column.shape)


def _text_array(texts: list[Any], field: ColumnField, topic: Topic) -> NDArray[Any]:
    if field.repeats and len({len(item) for item in texts}) > 1:
        raise _ragged(topic, field.name)
    return np.array(texts, dtype=np.str_) if texts else _nothing(field.column)


def _ragged(topic: Topic, name: str) -> Refused:
    return Refused(
        f"column {name} of {topic.name}",
        "of varying shape",
        "alike in every record",
        "read it record by record",
    )
