"""One column of a record on the wire, and how its values look in memory."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from math import prod
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sessions.errors import Refused
from sessions.records.fields import ROWS, Column
from sessions.store import wire
from sessions.store.damage import Damaged

_DTYPES: dict[str, np.dtype[Any]] = {
    "float64": np.dtype("<f8"),
    "float32": np.dtype("<f4"),
    "int64": np.dtype("<i8"),
    "uint8": np.dtype("u1"),
}
_SCALARS = {"float64": ("<d", wire.FIXED64), "float32": ("<f", wire.FIXED32), "int64": ("<q", wire.FIXED64)}
_MEMORY: dict[str, type[Any]] = {
    "float64": np.float64,
    "float32": np.float64,
    "int64": np.int64,
    "uint8": np.uint8,
    "string": np.str_,
}


@dataclass(frozen=True, slots=True)
class ColumnField:
    """One column together with its place in the message.

    Attributes:
        name: Field name of the record.
        number: Protobuf field number.
        column: Declaration of the field.
        tag: Bytes that announce the field.
        wire_type: Its kind on the wire.
    """

    name: str
    number: int
    column: Column
    tag: bytes
    wire_type: int

    @classmethod
    def of(cls, name: str, number: int, column: Column) -> ColumnField:
        """The field of a column declaration."""
        wire_type = wire.LENGTH
        if not column.shape and column.scalar != "string":
            wire_type = _SCALARS[column.scalar][1] if column.scalar in _SCALARS else wire.VARINT
        return cls(name, number, column, wire.tag(number, wire_type), wire_type)

    @property
    def repeats(self) -> bool:
        """Whether the field may occur more than once in a message (lists of strings)."""
        return self.column.scalar == "string" and bool(self.column.shape)

    @property
    def default_payload(self) -> bytes:
        """What an absent field means: zero, an empty text or an empty list."""
        if self.column.shape or self.column.scalar == "string":
            return b""
        return bytes(_DTYPES[self.column.scalar].itemsize)

    def encode(self, value: Any) -> bytes:
        """The whole field, tag included.

        Raises:
            Refused: The value has another shape or kind than the column declares.
        """
        try:
            if self.column.scalar == "string":
                return self._encode_text(value)
            return self._encode_array(value) if self.column.shape else self._encode_scalar(value)
        except (TypeError, ValueError, struct.error, OverflowError) as error:
            raise self._refusal(repr(value)[:60]) from error

    def decode(self, payloads: list[memoryview], rows: int) -> Any:
        """The value of one record, from the payloads that its message holds (none: protobuf's default).

        Raises:
            Damaged: The bytes do not fit the column.
        """
        if self.repeats:
            return tuple(text(payload) for payload in payloads)
        if len(payloads) > 1:
            raise Damaged(f"{self.name} occurs twice in a record")
        payload = payloads[0] if payloads else memoryview(self.default_payload)
        if self.column.scalar == "string":
            return text(payload)
        if self.column.shape:
            return self.elements(bytes(payload)).reshape(self.record_shape(self.count(payload), rows))
        numbers = self.elements(payload)
        if numbers.size != 1:
            raise Damaged(f"{self.name} is not one number")
        return numbers.item()

    def elements(self, payload: bytes | memoryview) -> NDArray[Any]:
        """All numbers (N,) of one or several payloads laid end to end, as they are held in memory."""
        if self.column.scalar == "uint8":
            return wire.unpack_bytes(payload)
        dtype = _DTYPES[self.column.scalar]
        if len(payload) % dtype.itemsize:
            raise Damaged(f"{self.name} ends within a number")
        return np.frombuffer(payload, dtype=dtype).astype(_MEMORY[self.column.scalar], copy=False)

    def count(self, payload: memoryview) -> int:
        """How many numbers a payload holds."""
        if self.column.scalar == "uint8":
            return int(wire.unpack_bytes(payload).size)
        return len(payload) // _DTYPES[self.column.scalar].itemsize

    def record_shape(self, count: int, rows: int) -> tuple[int, ...]:
        """Shape of one record's value that holds ``count`` numbers.

        Raises:
            Damaged: That many numbers cannot fill the declared shape.
        """
        shape = self.column.shape
        fixed = prod(size for size in shape if size != ROWS)
        if shape.count(ROWS) == 1:
            shape = (count // fixed, *shape[1:])
        elif shape.count(ROWS) > 1:
            shape = (rows, count // (rows * fixed) if rows else 0, *shape[2:])
        if prod(shape) != count:
            raise Damaged(f"{self.name} holds {count} numbers, which do not fill its shape")
        return shape

    def memory_dtype(self) -> type[Any]:
        """Kind of the column's numbers in memory; float32 is widened to float64."""
        return _MEMORY[self.column.scalar]

    def _encode_scalar(self, value: Any) -> bytes:
        if self.wire_type == wire.VARINT:
            return self.tag + wire.pack_bytes(np.array([value], dtype=np.uint8))
        return self.tag + struct.pack(_SCALARS[self.column.scalar][0], value)

    def _encode_text(self, value: Any) -> bytes:
        texts = value if self.repeats else (value,)
        encoded = [text.encode() for text in texts]
        return b"".join([self.tag + wire.varint(len(item)) + item for item in encoded])

    def _encode_array(self, value: Any) -> bytes:
        array: NDArray[Any] = np.asarray(value)
        dtype = _DTYPES[self.column.scalar]
        if array.dtype != dtype:
            with np.errstate(over="ignore"):  # a float64 beyond float32 is infinite there, as IEEE 754 says
                array = array.astype(dtype, casting="same_kind")
        shape = self.column.shape
        if len(array.shape) != len(shape) or any(
            declared not in (ROWS, met) for declared, met in zip(shape, array.shape, strict=True)
        ):
            raise self._refusal(f"of shape {array.shape}")
        body = wire.pack_bytes(array.ravel()) if self.column.scalar == "uint8" else array.tobytes()
        return self.tag + wire.varint(len(body)) + body

    def _refusal(self, value: str) -> Refused:
        shape = tuple("rows" if size == ROWS else size for size in self.column.shape)
        kind = f"{self.column.scalar} of shape {shape}" if self.column.shape else self.column.scalar
        return Refused(f"field {self.name}", value, kind, "correct the value before recording it")


def text(payload: memoryview) -> str:
    """A text from its bytes.

    Raises:
        Damaged: They are no UTF-8.
    """
    try:
        return str(payload, "utf-8")
    except UnicodeDecodeError as error:
        raise Damaged("a text is not UTF-8") from error
