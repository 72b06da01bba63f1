"""Protobuf descriptors of the record types, so that a stranger can read a file without this package.

Field numbers are the declaration order of the record's columns. The unit, shape and meaning of every field
travel with it as a comment. Foxglove's own schemas are restated here with their published names and numbers.
"""

from __future__ import annotations

from typing import Any

from google.protobuf.descriptor_pb2 import (
    DescriptorProto,
    FieldDescriptorProto,
    FileDescriptorProto,
    FileDescriptorSet,
)
from google.protobuf.timestamp_pb2 import DESCRIPTOR as TIMESTAMP_FILE

from sessions.records.fields import ROWS, Column, columns_of

ROWS_FIELD = 100
"""Field ``rows``: length of the first dimension, in types that hold (rows, columns) arrays."""

_TYPES = {
    "float64": FieldDescriptorProto.TYPE_DOUBLE,
    "float32": FieldDescriptorProto.TYPE_FLOAT,
    "int64": FieldDescriptorProto.TYPE_SFIXED64,
    "uint8": FieldDescriptorProto.TYPE_UINT32,
    "string": FieldDescriptorProto.TYPE_STRING,
}
_KINDS = {
    "string": FieldDescriptorProto.TYPE_STRING,
    "double": FieldDescriptorProto.TYPE_DOUBLE,
    "bytes": FieldDescriptorProto.TYPE_BYTES,
    "fixed32": FieldDescriptorProto.TYPE_FIXED32,
}
_STAMP = ("timestamp", ".google.protobuf.Timestamp")
_MESSAGE_PATH = (4, 0)  # message_type[0] of a FileDescriptorProto; its fields lie under (4, 0, 2, index)


def needs_rows(record_type: type[Any]) -> bool:
    """Whether a record type has an array whose two dimensions both vary."""
    return any(column.shape.count(ROWS) > 1 for column in columns_of(record_type).values())


def schema_of(record_type: type[Any], schema_name: str) -> bytes:
    """A serialised FileDescriptorSet for one record type.

    Args:
        record_type: The record class.
        schema_name: Full protobuf name, such as ``rehab.MarkerFrame``.
    """
    package, _, name = schema_name.rpartition(".")
    file = FileDescriptorProto(name=f"{package}/{name}.proto", package=package, syntax="proto3")
    message = file.message_type.add(name=name)
    _comment(file, _MESSAGE_PATH, (record_type.__doc__ or name).strip())
    for index, (field_name, column) in enumerate(columns_of(record_type).items()):
        message.field.add(name=field_name, number=index + 1, type=_TYPES[column.scalar], label=_label(column))
        _comment(file, (*_MESSAGE_PATH, 2, index), _describe(column))
    if needs_rows(record_type):
        message.field.add(
            name="rows",
            number=ROWS_FIELD,
            type=FieldDescriptorProto.TYPE_UINT32,
            label=FieldDescriptorProto.LABEL_OPTIONAL,
        )
        _comment(file, (*_MESSAGE_PATH, 2, len(message.field) - 1), "Length of the first dimension.")
    return FileDescriptorSet(file=[file]).SerializeToString(deterministic=True)


def foxglove_transforms() -> bytes:
    """FileDescriptorSet of ``foxglove.FrameTransforms``."""
    transform = _message("FrameTransform", _STAMP)
    for name in ("parent_frame_id", "child_frame_id"):
        _add(transform, name, "string")
    _add(transform, "translation", ".foxglove.Vector3")
    _add(transform, "rotation", ".foxglove.Quaternion")
    transforms = _message("FrameTransforms")
    _add(transforms, "transforms", ".foxglove.FrameTransform", repeated=True)
    vector = _message("Vector3", *((axis, "double") for axis in "xyz"))
    quaternion = _message("Quaternion", *((axis, "double") for axis in "xyzw"))
    return _set(vector, quaternion, transform, transforms)


def foxglove_joint_states() -> bytes:
    """FileDescriptorSet of ``foxglove.JointStates``; its values are optional, so absent differs from zero."""
    state = _message("JointState", ("name", "string"))
    for name in ("position", "velocity", "acceleration", "effort"):
        field = _add(state, name, "double")
        field.proto3_optional = True
        field.oneof_index = len(state.oneof_decl)
        state.oneof_decl.add(name=f"_{name}")
    states = _message("JointStates", _STAMP)
    _add(states, "joints", ".foxglove.JointState", repeated=True)
    return _set(state, states)


def foxglove_camera_calibration() -> bytes:
    """FileDescriptorSet of ``foxglove.CameraCalibration``."""
    sizes = (("width", "fixed32"), ("height", "fixed32"))
    calibration = _message("CameraCalibration", _STAMP, *sizes, ("distortion_model", "string"))
    for name in "DKRP":
        _add(calibration, name, "double", repeated=True)
    _add(calibration, "frame_id", "string")
    return _set(calibration)


def foxglove_compressed_image() -> bytes:
    """FileDescriptorSet of ``foxglove.CompressedImage``."""
    fields = (("data", "bytes"), ("format", "string"), ("frame_id", "string"))
    return _set(_message("CompressedImage", _STAMP, *fields))


def foxglove_raw_image() -> bytes:
    """FileDescriptorSet of ``foxglove.RawImage``."""
    sizes = (("width", "fixed32"), ("height", "fixed32"), ("encoding", "string"), ("step", "fixed32"))
    return _set(_message("RawImage", _STAMP, *sizes, ("data", "bytes"), ("frame_id", "string")))


def _label(column: Column) -> FieldDescriptorProto.Label.ValueType:
    if column.shape:
        return FieldDescriptorProto.LABEL_REPEATED
    return FieldDescriptorProto.LABEL_OPTIONAL


def _describe(column: Column) -> str:
    shape = ", ".join("rows" if size == ROWS else str(size) for size in column.shape)
    layout = f" Shape ({shape}), row by row." if column.shape else ""
    return f"{column.meaning} [{column.unit}].{layout}"


def _comment(file: FileDescriptorProto, path: tuple[int, ...], text: str) -> None:
    file.source_code_info.location.add(path=path, span=(0, 0, 0), leading_comments=f" {text}\n")


def _message(name: str, *fields: tuple[str, str]) -> DescriptorProto:
    message = DescriptorProto(name=name)
    for field_name, kind in fields:
        _add(message, field_name, kind)
    return message


def _add(message: DescriptorProto, name: str, kind: str, *, repeated: bool = False) -> FieldDescriptorProto:
    label = FieldDescriptorProto.LABEL_REPEATED if repeated else FieldDescriptorProto.LABEL_OPTIONAL
    field = message.field.add(name=name, number=len(message.field) + 1, label=label)
    if kind.startswith("."):
        field.type = FieldDescriptorProto.TYPE_MESSAGE
        field.type_name = kind
    else:
        field.type = _KINDS[kind]
    return field


def _set(*messages: DescriptorProto) -> bytes:
    """A set of one file per message, each importing those before it, as Foxglove lays its schemas out."""
    timestamp = FileDescriptorProto()
    TIMESTAMP_FILE.CopyToProto(timestamp)
    files = [timestamp]
    for message in messages:
        needed = {field.type_name for field in message.field if field.type_name}
        imports = [file.name for file in files if f".{file.package}.{file.message_type[0].name}" in needed]
        name = f"foxglove/{message.name}.proto"
        file = FileDescriptorProto(name=name, package="foxglove", syntax="proto3", dependency=imports)
        file.message_type.append(message)
        files.append(file)
    return FileDescriptorSet(file=files).SerializeToString(deterministic=True)
