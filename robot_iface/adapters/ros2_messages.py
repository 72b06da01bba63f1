"""The ROS 2 messages that a hand needs, declared so that DDS carries the bytes that ROS 2 itself speaks.

Names of types and the order of fields are those of ROS 2's own interface packages; DDS type names are theirs
as well (``package::msg::dds_::Name_``). This module needs the ``ros2`` extra.
"""

# The annotations of these classes are read when they are made, so they must be types, not text.
from dataclasses import dataclass
from typing import TYPE_CHECKING

from cyclonedds.idl import IdlStruct
from cyclonedds.idl.types import float64, int32, sequence, uint32

if TYPE_CHECKING:
    Texts = list[str]
    Numbers = list[float]
else:
    Texts = sequence[str]
    Numbers = sequence[float64]


@dataclass
class Time(IdlStruct, typename="builtin_interfaces::msg::dds_::Time_"):
    """Time since the epoch; zero means now."""

    sec: int32
    nanosec: uint32


@dataclass
class Duration(IdlStruct, typename="builtin_interfaces::msg::dds_::Duration_"):
    """A span of time."""

    sec: int32
    nanosec: uint32


@dataclass
class Header(IdlStruct, typename="std_msgs::msg::dds_::Header_"):
    """When, and in which frame."""

    stamp: Time
    frame_id: str


@dataclass
class JointState(IdlStruct, typename="sensor_msgs::msg::dds_::JointState_"):
    """Measured positions (rad), velocities (rad/s) and efforts (Nm) of named joints."""

    header: Header
    name: Texts
    position: Numbers
    velocity: Numbers
    effort: Numbers


@dataclass
class JointTrajectoryPoint(IdlStruct, typename="trajectory_msgs::msg::dds_::JointTrajectoryPoint_"):
    """Where joints should be, and when."""

    positions: Numbers
    velocities: Numbers
    accelerations: Numbers
    effort: Numbers
    time_from_start: Duration


if TYPE_CHECKING:
    Points = list[JointTrajectoryPoint]
else:
    Points = sequence[JointTrajectoryPoint]


@dataclass
class JointTrajectory(IdlStruct, typename="trajectory_msgs::msg::dds_::JointTrajectory_"):
    """Points for named joints."""

    header: Header
    joint_names: Texts
    points: Points


@dataclass
class MultiArrayDimension(IdlStruct, typename="std_msgs::msg::dds_::MultiArrayDimension_"):
    """One axis of an array."""

    label: str
    size: uint32
    stride: uint32


if TYPE_CHECKING:
    Axes = list[MultiArrayDimension]
else:
    Axes = sequence[MultiArrayDimension]


@dataclass
class MultiArrayLayout(IdlStruct, typename="std_msgs::msg::dds_::MultiArrayLayout_"):
    """The axes of an array."""

    dim: Axes
    data_offset: uint32


@dataclass
class Float64MultiArray(IdlStruct, typename="std_msgs::msg::dds_::Float64MultiArray_"):
    """Numbers; here one effort (Nm) per joint, as forward command controllers take them."""

    layout: MultiArrayLayout
    data: Numbers


@dataclass
class Bool(IdlStruct, typename="std_msgs::msg::dds_::Bool_"):
    """Yes or no."""

    data: bool


@dataclass
class String(IdlStruct, typename="std_msgs::msg::dds_::String_"):
    """A text."""

    data: str
