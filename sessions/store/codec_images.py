"""Camera calibration, colour and depth in Foxglove's published schemas, which viewers draw without us."""

from __future__ import annotations

import struct
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sessions.errors import Refused
from sessions.records import CameraCalibration, ColourImage, DepthImage
from sessions.records.fields import Float64
from sessions.store import wire
from sessions.store.codec_foxglove import timestamp
from sessions.store.columnfields import text
from sessions.store.damage import Damaged
from sessions.store.schema import foxglove_camera_calibration, foxglove_compressed_image, foxglove_raw_image

_DEPTH_ENCODING = "16UC1"
_FIXED32 = struct.Struct("<I")
_NO_DISTORTION = np.zeros(5)


class CalibrationCodec:
    """``foxglove.CameraCalibration`` without distortion: R is the identity, P is K and a zero column."""

    schema = foxglove_camera_calibration()

    def encode(self, record: CameraCalibration, utc_ns: int) -> bytes:
        """The message of a record.

        Raises:
            Refused: The matrix is not 3 by 3, or a size is out of bounds.
        """
        matrix = np.asarray(record.camera_matrix_px, np.float64)
        if matrix.shape != (3, 3):
            raise Refused("camera matrix", f"of shape {matrix.shape}", "3 by 3", "give fx, fy, cx and cy")
        projection = np.hstack([matrix, np.zeros((3, 1))])
        return b"".join(
            [
                wire.delimited(1, timestamp(utc_ns)),
                _size(2, record.width_px),
                _size(3, record.height_px),
                wire.delimited(4, b"plumb_bob"),
                *(
                    wire.delimited(number, np.ascontiguousarray(values, "<f8").tobytes())
                    for number, values in enumerate((_NO_DISTORTION, matrix, np.eye(3), projection), start=5)
                ),
                wire.delimited(9, _encoded(record.frame_id)),
            ]
        )

    def decode(self, data: memoryview, t_ns: int) -> CameraCalibration:
        """The record of a message.

        Raises:
            Damaged: The message does not follow the schema.
        """
        found = _fields(data)
        matrix = _numbers(found.get(6, b""))
        if matrix.size != 9:
            raise Damaged("a camera matrix does not hold nine numbers")
        return CameraCalibration(
            t_ns=t_ns,
            frame_id=_text(found, 9),
            width_px=_number(found, 2),
            height_px=_number(found, 3),
            camera_matrix_px=matrix.reshape(3, 3),
        )


class ColourImageCodec:
    """``foxglove.CompressedImage``."""

    schema = foxglove_compressed_image()

    def encode(self, record: ColourImage, utc_ns: int) -> bytes:
        """The message of a record.

        Raises:
            Refused: The image is not a row of bytes.
        """
        encoded: NDArray[Any] = np.asarray(record.encoded)
        if encoded.dtype != np.uint8 or encoded.ndim != 1:
            raise Refused("colour image", f"{encoded.dtype} {encoded.shape}", "bytes", "encode it as JPEG")
        return b"".join(
            [
                wire.delimited(1, timestamp(utc_ns)),
                wire.delimited(2, encoded.tobytes()),
                wire.delimited(3, _encoded(record.format)),
                wire.delimited(4, _encoded(record.frame_id)),
            ]
        )

    def decode(self, data: memoryview, t_ns: int) -> ColourImage:
        """The record of a message.

        Raises:
            Damaged: The message does not follow the schema.
        """
        found = _fields(data)
        return ColourImage(
            t_ns=t_ns,
            frame_id=_text(found, 4),
            format=_text(found, 3),
            encoded=np.frombuffer(bytes(found.get(2, b"")), np.uint8),
        )


class DepthImageCodec:
    """``foxglove.RawImage`` with encoding 16UC1: little-endian millimetres, row by row."""

    schema = foxglove_raw_image()

    def encode(self, record: DepthImage, utc_ns: int) -> bytes:
        """The message of a record.

        Raises:
            Refused: The depth is not an image of 16-bit numbers.
        """
        depth: NDArray[Any] = np.asarray(record.depth_mm)
        if depth.dtype != np.uint16 or depth.ndim != 2:
            raise Refused("depth image", f"{depth.dtype} {depth.shape}", "uint16 rows", "round it to mm")
        return b"".join(
            [
                wire.delimited(1, timestamp(utc_ns)),
                _size(2, depth.shape[1]),
                _size(3, depth.shape[0]),
                wire.delimited(4, _DEPTH_ENCODING.encode()),
                _size(5, 2 * depth.shape[1]),
                wire.delimited(6, np.ascontiguousarray(depth, "<u2").tobytes()),
                wire.delimited(7, _encoded(record.frame_id)),
            ]
        )

    def decode(self, data: memoryview, t_ns: int) -> DepthImage:
        """The record of a message.

        Raises:
            Damaged: The message does not follow the schema, or is no depth image.
        """
        found = _fields(data)
        width, height, pixels = _number(found, 2), _number(found, 3), bytes(found.get(6, b""))
        if _text(found, 4) != _DEPTH_ENCODING or len(pixels) != 2 * width * height:
            raise Damaged(f"a depth image is not {_DEPTH_ENCODING} or not as large as it says")
        depth = np.frombuffer(pixels, "<u2").reshape(height, width)
        return DepthImage(t_ns=t_ns, frame_id=_text(found, 7), depth_mm=depth)


def _size(number: int, value: int) -> bytes:
    """A fixed32 field.

    Raises:
        Refused: The value is no size of an image.
    """
    if not 0 <= value <= 0xFFFFFFFF:
        raise Refused("image size", f"{value} px", "0 px or more", "give the size of the image")
    return wire.tag(number, wire.FIXED32) + _FIXED32.pack(value)


def _encoded(name: str) -> bytes:
    try:
        return name.encode()
    except UnicodeEncodeError as error:
        raise Refused("name", ascii(name), "text that UTF-8 can hold", "rename it") from error


def _fields(data: memoryview) -> dict[int, memoryview]:
    """The last payload of every field, by number."""
    return {number: data[start:end] for number, _, start, end in wire.walk(data)}


def _text(found: dict[int, memoryview], number: int) -> str:
    return text(found[number]) if number in found else ""


def _number(found: dict[int, memoryview], number: int) -> int:
    payload = found.get(number)
    if payload is None:
        return 0
    if len(payload) != _FIXED32.size:
        raise Damaged("an image size is not one number")
    return int(_FIXED32.unpack(payload)[0])


def _numbers(payload: memoryview | bytes) -> Float64:
    if len(payload) % 8:
        raise Damaged("a camera matrix ends within a number")
    return np.frombuffer(bytes(payload), "<f8").astype(np.float64)
