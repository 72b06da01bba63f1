"""Frames and joint angles in Foxglove's published schemas, which viewers draw without knowing us."""

from __future__ import annotations

import struct
from functools import lru_cache
from typing import Any

import numpy as np

from sessions.errors import Refused
from sessions.records import JointStates, Transforms
from sessions.records.fields import Float64
from sessions.store import wire
from sessions.store.columnfields import text
from sessions.store.schema import foxglove_joint_states, foxglove_transforms

_NS_PER_S = 1_000_000_000
_X, _Y, _Z, _W = (wire.tag(number, wire.FIXED64)[0] for number in (1, 2, 3, 4))
_TRANSLATION, _ROTATION = wire.tag(4, wire.LENGTH)[0], wire.tag(5, wire.LENGTH)[0]
_POSE = struct.Struct("<BB BdBdBd BB BdBdBdBd".replace(" ", ""))
_POSITION = struct.Struct("<Bd")
_DOUBLE = struct.Struct("<d")
_POSE_NUMBERS = 7


class TransformsCodec:
    """``foxglove.FrameTransforms``; every transform carries the record's UTC time, quaternions are xyzw."""

    schema = foxglove_transforms()

    def encode(self, record: Transforms, utc_ns: int) -> bytes:
        """The message of a record.

        Raises:
            Refused: The columns differ in their number of rows.
        """
        count = len(record.parents)
        positions = _rows(record.p_parent_child_m, (count, 3), "p_parent_child_m")
        rotations = _rows(record.q_parent_child_wxyz, (count, 4), "q_parent_child_wxyz")
        if len(record.children) != count:
            raise Refused("children", f"{len(record.children)} names", f"{count}", "name one per transform")
        stamp = wire.delimited(1, timestamp(utc_ns))
        parts: list[bytes] = []
        for parent, child, (x, y, z), (w, i, j, k) in zip(
            record.parents, record.children, positions.tolist(), rotations.tolist(), strict=True
        ):
            pose = _POSE.pack(
                _TRANSLATION, 27, _X, x, _Y, y, _Z, z, _ROTATION, 36, _X, i, _Y, j, _Z, k, _W, w
            )
            body = stamp + _frame_names(parent, child) + pose
            parts.append(b"\x0a" + wire.varint(len(body)) + body)
        return b"".join(parts)

    def decode(self, data: memoryview, t_ns: int) -> Transforms:
        """The record of a message.

        Raises:
            Damaged: The message does not follow the schema.
        """
        rows = [_transform(data[start:end]) for start, end in _spans(data, 1)]
        numbers = np.array([row[2] for row in rows], dtype=np.float64).reshape(-1, _POSE_NUMBERS)
        return Transforms(
            t_ns=t_ns,
            parents=tuple(row[0] for row in rows),
            children=tuple(row[1] for row in rows),
            p_parent_child_m=numbers[:, :3],
            q_parent_child_wxyz=numbers[:, [6, 3, 4, 5]],
        )


class JointStatesCodec:
    """``foxglove.JointStates`` with name and position; an absent position is NaN in memory."""

    schema = foxglove_joint_states()

    def encode(self, record: JointStates, utc_ns: int) -> bytes:
        """The message of a record.

        Raises:
            Refused: There is not one position per name.
        """
        positions = _rows(record.positions_rad, (len(record.names),), "positions_rad")
        tag = wire.tag(2, wire.FIXED64)[0]
        parts = [wire.delimited(1, timestamp(utc_ns))]
        for name, position in zip(record.names, positions.tolist(), strict=True):
            parts.append(wire.delimited(2, _joint_name(name) + _POSITION.pack(tag, position)))
        return b"".join(parts)

    def decode(self, data: memoryview, t_ns: int) -> JointStates:
        """The record of a message.

        Raises:
            Damaged: The message does not follow the schema.
        """
        rows = [_joint(data[start:end]) for start, end in _spans(data, 2)]
        angles = np.array([angle for _, angle in rows], dtype=np.float64)
        return JointStates(t_ns=t_ns, names=tuple(name for name, _ in rows), positions_rad=angles)


def timestamp(utc_ns: int) -> bytes:
    """A ``google.protobuf.Timestamp`` of a UTC time in ns."""
    seconds, nanos = divmod(utc_ns, _NS_PER_S)
    return wire.tag(1, wire.VARINT) + wire.varint(seconds) + wire.tag(2, wire.VARINT) + wire.varint(nanos)


@lru_cache(maxsize=1024)
def _frame_names(parent: str, child: str) -> bytes:
    return wire.delimited(2, _encoded(parent)) + wire.delimited(3, _encoded(child))


@lru_cache(maxsize=1024)
def _joint_name(name: str) -> bytes:
    return wire.delimited(1, _encoded(name))


def _encoded(text: str) -> bytes:
    try:
        return text.encode()
    except UnicodeEncodeError as error:
        raise Refused("name", ascii(text), "text that UTF-8 can hold", "rename it") from error


def _rows(values: Any, shape: tuple[int, ...], name: str) -> Float64:
    array = np.asarray(values, dtype=np.float64)
    if array.shape != shape:
        raise Refused(
            f"field {name}", f"of shape {array.shape}", f"of shape {shape}", "give one row per name"
        )
    return array


def _spans(data: memoryview, number: int) -> list[tuple[int, int]]:
    return [(start, end) for met, kind, start, end in wire.walk(data) if (met, kind) == (number, wire.LENGTH)]


def _transform(data: memoryview) -> tuple[str, str, list[float]]:
    names = {2: "", 3: ""}
    pose = [0.0] * _POSE_NUMBERS
    for number, kind, start, end in wire.walk(data):
        if kind == wire.LENGTH and number in names:
            names[number] = text(data[start:end])
        elif kind == wire.LENGTH and number in (4, 5):
            first, size = (0, 3) if number == 4 else (3, 4)
            for axis, axis_kind, at, _ in wire.walk(data[start:end]):
                if axis_kind == wire.FIXED64 and axis <= size:
                    pose[first + axis - 1] = _DOUBLE.unpack_from(data, start + at)[0]
    return names[2], names[3], pose


def _joint(data: memoryview) -> tuple[str, float]:
    name, angle = "", float("nan")
    for number, kind, start, end in wire.walk(data):
        if (number, kind) == (1, wire.LENGTH):
            name = text(data[start:end])
        elif (number, kind) == (2, wire.FIXED64):
            angle = _DOUBLE.unpack_from(data, start)[0]
    return name, angle
