"""Our bytes are ROS 2's bytes: an independent reader and writer of ROS 2 messages agrees, both ways."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from rosbags.typesys import Stores, get_typestore

from robot_iface.adapters import ros2_messages as ros

STORE: Any = get_typestore(Stores.ROS2_HUMBLE)
HEADER = ros.Header(ros.Time(12, 345_678_901), "palm")
NAMES = ["finger joint 1", "ä", ""]
NUMBERS = [0.1, -2.5e-300, float("inf")]
MESSAGES = [
    ros.JointState(HEADER, NAMES, NUMBERS, [1.0, 2.0, 3.0], []),
    ros.JointState(HEADER, [], [], [], []),
    ros.JointTrajectory(
        HEADER,
        NAMES,
        [
            ros.JointTrajectoryPoint(NUMBERS, NUMBERS, [], [], ros.Duration(0, 2_000_000)),
            ros.JointTrajectoryPoint([], [], NUMBERS, [4.0], ros.Duration(-1, 7)),
        ],
    ),
    ros.Float64MultiArray(ros.MultiArrayLayout([ros.MultiArrayDimension("joint", 3, 3)], 0), NUMBERS),
    ros.Float64MultiArray(ros.MultiArrayLayout([], 0), NUMBERS),
    ros.Bool(True),
    ros.Bool(False),
    ros.String("over-current, encoder"),
]


def ros_name(message: Any) -> str:
    """``sensor_msgs::msg::dds_::JointState_`` is ``sensor_msgs/msg/JointState``."""
    return message.__idl_typename__.replace("::dds_::", "/").replace("::", "/").removesuffix("_")


def same(ours: Any, theirs: Any) -> bool:
    if hasattr(ours, "__idl_typename__"):
        names = [name for name in ours.__dataclass_fields__ if name != "sample_info"]
        return all(same(getattr(ours, name), getattr(theirs, name)) for name in names)
    if isinstance(ours, list):
        return len(ours) == len(theirs) and all(same(*pair) for pair in zip(ours, theirs, strict=True))
    return bool(ours == theirs)


@pytest.mark.parametrize("message", MESSAGES, ids=lambda message: type(message).__name__)
def test_what_we_write_ros_reads(message: Any) -> None:
    content = message.serialize(use_version_2=False)
    assert content[:4] == b"\x00\x01\x00\x00", "not plain little-endian CDR"
    assert same(message, STORE.deserialize_cdr(content, ros_name(message)))


@pytest.mark.parametrize("message", MESSAGES, ids=lambda message: type(message).__name__)
def test_what_ros_writes_we_read(message: Any) -> None:
    theirs = STORE.deserialize_cdr(message.serialize(use_version_2=False), ros_name(message))
    content = bytes(STORE.serialize_cdr(theirs, ros_name(message)))
    assert same(type(message).deserialize(content), theirs)


def test_numbers_come_through_as_they_are() -> None:
    content = ros.JointState(HEADER, NAMES, NUMBERS, NUMBERS, NUMBERS).serialize(use_version_2=False)
    theirs = STORE.deserialize_cdr(content, "sensor_msgs/msg/JointState")
    np.testing.assert_array_equal(theirs.position, NUMBERS)
    assert theirs.header.stamp.nanosec == 345_678_901
