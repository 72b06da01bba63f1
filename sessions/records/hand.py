"""What a camera, an importer or a robot says of a hand at one instant."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

from sessions.records.fields import ROWS, Float64, UInt8, column


class Status(IntEnum):
    """How a marker or joint value came about; only MEASURED values enter a metric unflagged."""

    LOST = 0
    ESTIMATED = 1
    MEASURED = 2


@dataclass(frozen=True, slots=True, kw_only=True)
class MarkerFrame:
    """All markers of one capture. Rows follow ``SessionHeader.marker_names``; a gap is NaN and LOST."""

    t_ns: int = column("int64", (), "ns", "capture time, monotonic")
    p_camera_m: Float64 = column("float64", (ROWS, 3), "m", "marker positions in the camera frame")
    covariance_m2: Float64 = column("float32", (ROWS, 3, 3), "m^2", "covariance of each position")
    status: UInt8 = column("uint8", (ROWS,), "1", "0 lost, 1 estimated, 2 measured")
    pixel_px: Float64 = column("float64", (ROWS, 2), "px", "image position u v, NaN where there is none")
    similarity: Float64 = column("float32", (ROWS,), "1", "likeness to the marker model, 0 to 1")


@dataclass(frozen=True, slots=True, kw_only=True)
class HandPose:
    """The hand fitted to one capture: where the palm is, the 21 joints, the five fingertips."""

    t_ns: int = column("int64", (), "ns", "capture time, monotonic")
    p_camera_palm_m: Float64 = column("float64", (3,), "m", "origin of the palm frame in the camera frame")
    q_camera_palm_wxyz: Float64 = column("float64", (4,), "1", "rotation from palm to camera frame")
    joints_rad: Float64 = column("float64", (21,), "rad", "joint angles in the order of JOINTS")
    joint_covariance_rad2: Float64 = column("float32", (21, 21), "rad^2", "covariance of the joint angles")
    joint_status: UInt8 = column("uint8", (21,), "1", "0 lost, 1 estimated, 2 measured, by joint")
    fingertips_palm_m: Float64 = column("float64", (5, 3), "m", "fingertips in the palm frame")
    fingertip_covariance_m2: Float64 = column("float32", (5, 3, 3), "m^2", "covariance of each fingertip")
    residual_m: float = column(
        "float64", (), "m", "rms distance of fitted from observed landmarks, NaN if none"
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class JointStates:
    """Joint angles in Foxglove's schema, at 30 Hz or less, for strangers' viewers."""

    t_ns: int = column("int64", (), "ns", "capture time, monotonic")
    names: tuple[str, ...] = column("string", (ROWS,), "1", "joint names")
    positions_rad: Float64 = column("float64", (ROWS,), "rad", "joint angles")


@dataclass(frozen=True, slots=True, kw_only=True)
class Transforms:
    """Frames of one instant, written as ``foxglove.FrameTransforms``."""

    t_ns: int = column("int64", (), "ns", "time, monotonic")
    parents: tuple[str, ...] = column("string", (ROWS,), "1", "parent frame of each transform")
    children: tuple[str, ...] = column("string", (ROWS,), "1", "child frame, such as patient/index_tip")
    p_parent_child_m: Float64 = column("float64", (ROWS, 3), "m", "child origin in the parent frame")
    q_parent_child_wxyz: Float64 = column("float64", (ROWS, 4), "1", "rotation from child to parent frame")
