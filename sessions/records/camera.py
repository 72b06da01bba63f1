"""What a camera saw, in Foxglove's schemas; images are written only with consent."""

from __future__ import annotations

from dataclasses import dataclass

from sessions.records.fields import ROWS, Float64, UInt8, UInt16, column


@dataclass(frozen=True, slots=True, kw_only=True)
class CameraCalibration:
    """The pinhole camera of colour and depth, written as ``foxglove.CameraCalibration``."""

    t_ns: int = column("int64", (), "ns", "time, monotonic")
    frame_id: str = column("string", (), "1", "frame of the camera, OpenCV's axes")
    width_px: int = column("uint16", (), "px", "image width")
    height_px: int = column("uint16", (), "px", "image height")
    camera_matrix_px: Float64 = column("float64", (3, 3), "px", "pinhole matrix: fx 0 cx, 0 fy cy, 0 0 1")


@dataclass(frozen=True, slots=True, kw_only=True)
class ColourImage:
    """One colour image, written as ``foxglove.CompressedImage``."""

    t_ns: int = column("int64", (), "ns", "capture time, monotonic")
    frame_id: str = column("string", (), "1", "frame of the camera")
    format: str = column("string", (), "1", "jpeg")
    encoded: UInt8 = column("uint8", (ROWS,), "1", "the bytes of the image file")


@dataclass(frozen=True, slots=True, kw_only=True)
class DepthImage:
    """Depth registered to the colour image, written as ``foxglove.RawImage`` with encoding 16UC1."""

    t_ns: int = column("int64", (), "ns", "capture time, monotonic; equal to that of its colour image")
    frame_id: str = column("string", (), "1", "frame of the camera")
    depth_mm: UInt16 = column("uint16", (ROWS, ROWS), "mm", "depth along the optical axis, 0 where unknown")
