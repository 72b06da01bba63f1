"""Records to protobuf messages and back, derived from the declarations of the record types."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from typing import Any, Protocol

from sessions.errors import Refused
from sessions.records import (
    CameraCalibration,
    ColourImage,
    DepthImage,
    JointStates,
    Topic,
    Transforms,
    columns_of,
)
from sessions.records.fields import ROWS
from sessions.store import wire
from sessions.store.codec_foxglove import JointStatesCodec, TransformsCodec
from sessions.store.codec_images import CalibrationCodec, ColourImageCodec, DepthImageCodec
from sessions.store.columnfields import ColumnField
from sessions.store.damage import Damaged
from sessions.store.schema import ROWS_FIELD, needs_rows, schema_of

Payloads = Mapping[int, list[memoryview]]


class Codec(Protocol):
    """Turns the records of one topic into bytes and back."""

    schema: bytes

    def encode(self, record: Any, utc_ns: int) -> bytes:
        """The message of a record; ``utc_ns`` is its time for schemas that carry UTC."""
        ...

    def decode(self, data: memoryview, t_ns: int) -> Any:
        """The record of a message; ``t_ns`` is its monotonic time for schemas that carry UTC."""
        ...


class TableCodec:
    """Codec of one of our own record types.

    Attributes:
        schema: Serialised FileDescriptorSet.
        fields: Columns on the wire, by field number.
    """

    def __init__(self, record_type: type[Any], schema_name: str) -> None:
        self.schema = schema_of(record_type, schema_name)
        self.fields = {
            number: ColumnField.of(name, number, column)
            for number, (name, column) in enumerate(columns_of(record_type).items(), start=1)
        }
        self._type = record_type
        self._rows_tag = wire.tag(ROWS_FIELD, wire.VARINT) if needs_rows(record_type) else b""
        self._tall = [field for field in self.fields.values() if field.column.shape[:1] == (ROWS,)]

    def encode(self, record: Any, utc_ns: int) -> bytes:
        """The message of a record.

        Raises:
            Refused: A field does not fit its declaration, or the fields differ in their number of rows.
        """
        parts = [field.encode(getattr(record, field.name)) for field in self.fields.values()]
        if self._tall:
            rows = {field.name: len(getattr(record, field.name)) for field in self._tall}
            if len(set(rows.values())) > 1:
                raise Refused(f"{self._type.__name__}", f"of rows {rows}", "of one length", "align its rows")
            if self._rows_tag:
                parts.append(self._rows_tag + wire.varint(next(iter(rows.values()))))
        return b"".join(parts)

    def decode(self, data: memoryview, t_ns: int) -> Any:
        """The record of a message.

        Raises:
            Damaged: The message does not follow the schema.
        """
        payloads, rows = self.payloads(data)
        values = {
            field.name: field.decode(payloads.get(number, []), rows) for number, field in self.fields.items()
        }
        if len({len(values[field.name]) for field in self._tall}) > 1:
            raise Damaged(f"the rows of a {self._type.__name__} differ in number")
        return self._type(**values)

    def payloads(self, data: memoryview) -> tuple[Payloads, int]:
        """The payloads of a message by field number, and its ``rows``; unknown fields are passed over."""
        found: dict[int, list[memoryview]] = {}
        rows = 0
        for number, wire_type, start, end in wire.walk(data):
            if number == ROWS_FIELD and wire_type == wire.VARINT:
                rows = wire.read_varint(data, start)[0]
            field = self.fields.get(number)
            if field is None:
                continue
            if wire_type != field.wire_type:
                raise Damaged(f"{field.name} is of another kind than its schema says")
            found.setdefault(number, []).append(data[start:end])
        return found, rows


_PUBLISHED: dict[type[Any], Callable[[], Codec]] = {
    Transforms: TransformsCodec,
    JointStates: JointStatesCodec,
    CameraCalibration: CalibrationCodec,
    ColourImage: ColourImageCodec,
    DepthImage: DepthImageCodec,
}


@cache
def codec_for(topic: Topic) -> Codec:
    """The codec of a topic; Foxglove's schemas where one fits, else the table of columns."""
    published = _PUBLISHED.get(topic.record)
    return TableCodec(topic.record, topic.schema) if published is None else published()
