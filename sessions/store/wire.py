"""Protobuf's wire format: varints, tags, and the walk over the fields of one message.

Source: https://protobuf.dev/programming-guides/encoding. Packed doubles, floats and sfixed64 lie on the
wire as contiguous little-endian numbers, which is why numpy can read and write them as they are.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from sessions.records.fields import UInt8
from sessions.store.damage import Damaged

VARINT, FIXED64, LENGTH, FIXED32 = 0, 1, 2, 5
_FIXED_BYTES = {FIXED64: 8, FIXED32: 4}
_VARINT_BYTES_MAX = 10
Field = tuple[int, int, int, int]


def varint(value: int) -> bytes:
    """A non-negative integer as a varint."""
    out = bytearray()
    while value > 0x7F:
        out.append(value & 0x7F | 0x80)
        value >>= 7
    out.append(value)
    return bytes(out)


def read_varint(data: memoryview, position: int) -> tuple[int, int]:
    """Value of the varint at a position, and the position after it.

    Raises:
        Damaged: It does not end within the data or within ten bytes.
    """
    value = shift = 0
    try:
        while shift < 7 * _VARINT_BYTES_MAX:
            byte = data[position]
            position += 1
            if byte < 0x80:
                return value | byte << shift, position
            value |= (byte & 0x7F) << shift
            shift += 7
    except IndexError:
        pass
    raise Damaged("a number does not end")


def tag(number: int, wire_type: int) -> bytes:
    """The bytes that announce a field."""
    return varint(number << 3 | wire_type)


def delimited(number: int, payload: bytes) -> bytes:
    """A whole length-delimited field: tag, length, payload."""
    return tag(number, LENGTH) + varint(len(payload)) + payload


def walk(data: memoryview) -> Iterator[Field]:
    """Yield (field number, wire type, payload start, payload end) of every field of a message.

    Raises:
        Damaged: A field reaches beyond the data, or its kind does not exist.
    """
    position, size = 0, len(data)
    while position < size:
        key = data[position]
        position += 1
        if key > 0x7F:
            key, position = read_varint(data, position - 1)
        start, end = _payload(data, key & 7, position)
        if end > size or key < 8:
            raise Damaged("a field reaches beyond its message")
        yield key >> 3, key & 7, start, end
        position = end


def _payload(data: memoryview, wire_type: int, position: int) -> tuple[int, int]:
    """Where the payload of a field lies, given where its tag ended."""
    if wire_type == LENGTH:
        length, start = read_varint(data, position)
        return start, start + length
    if wire_type == VARINT:
        return position, read_varint(data, position)[1]
    if wire_type not in _FIXED_BYTES:
        raise Damaged(f"field kind {wire_type} does not exist")
    return position, position + _FIXED_BYTES[wire_type]


def pack_bytes(values: UInt8) -> bytes:
    """Small integers (N,) as packed varints: one byte each below 128, two above."""
    if values.size == 0 or int(values.max()) < 0x80:
        return values.tobytes()
    pairs = np.stack((values | 0x80, values >> 7), axis=-1)
    pairs[values < 0x80, 0] = values[values < 0x80]
    keep = np.stack((np.ones_like(values, dtype=bool), values >= 0x80), axis=-1)
    return pairs[keep].tobytes()


def unpack_bytes(payload: memoryview | bytes) -> UInt8:
    """The inverse of ``pack_bytes``: values (N,).

    Raises:
        Damaged: A value is above 255 or does not end.
    """
    raw = np.frombuffer(payload, dtype=np.uint8)
    high = raw > 0x7F
    if not high.any():
        return raw
    follows = np.concatenate(([False], high[:-1]))
    if high[-1] or np.any(raw[follows] > 1):
        raise Damaged("a small integer is above 255")
    values: UInt8 = raw & np.uint8(0x7F)
    values[high] |= raw[follows] << np.uint8(7)
    return values[~follows]
