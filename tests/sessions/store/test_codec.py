from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from google.protobuf import descriptor_pb2, descriptor_pool, message_factory
from google.protobuf.message import Message

from sessions.errors import Refused
from sessions.records import TOPICS, JointStates, MarkerFrame, Topic, Transforms, columns_of
from sessions.records.fields import ROWS
from sessions.records.topics import HAND_JOINTS, MARKERS, ROBOT_STATE, TRANSFORMS
from sessions.store.codec import codec_for
from sessions.store.damage import Damaged

UTC_NS = 1_790_000_000_123_456_789
OWN = [topic for topic in TOPICS.values() if topic.schema.startswith("rehab.")]
Maker = Callable[[Topic, int, np.random.Generator], Any]


def library_class(topic: Topic) -> type[Message]:
    """The message class that protobuf itself builds from the schema in the file."""
    pool = descriptor_pool.DescriptorPool()
    for file in descriptor_pb2.FileDescriptorSet.FromString(codec_for(topic).schema).file:
        pool.Add(file)
    return message_factory.GetMessageClass(pool.FindMessageTypeByName(topic.schema))


def assert_equal(met: Any, expected: Any) -> None:
    assert type(met) is type(expected)
    for name in columns_of(type(expected)):
        one, other = getattr(met, name), getattr(expected, name)
        if isinstance(other, np.ndarray):
            np.testing.assert_array_equal(one, other)
            assert one.dtype == other.dtype
            assert one.shape == other.shape
        else:
            assert one == other


@pytest.mark.parametrize("topic", TOPICS.values(), ids=lambda topic: topic.name)
def test_what_was_encoded_is_decoded(topic: Topic, maker: Maker) -> None:
    record = maker(topic, 42, np.random.default_rng(1))
    codec = codec_for(topic)
    assert_equal(codec.decode(memoryview(codec.encode(record, UTC_NS)), 42), record)


@pytest.mark.parametrize("topic", OWN, ids=lambda topic: topic.name)
def test_the_protobuf_library_reads_our_bytes(topic: Topic, maker: Maker) -> None:
    record = maker(topic, 42, np.random.default_rng(2))
    message = library_class(topic).FromString(codec_for(topic).encode(record, UTC_NS))
    for name, column in columns_of(topic.record).items():
        met, expected = getattr(message, name), getattr(record, name)
        if column.scalar == "string":
            assert (tuple(met) if column.shape else met) == expected
        else:
            np.testing.assert_array_equal(np.asarray(met), np.ravel(expected) if column.shape else expected)
    if any(column.shape.count(ROWS) > 1 for column in columns_of(topic.record).values()):
        assert message.rows == len(record.t_ns)


@pytest.mark.parametrize("topic", OWN, ids=lambda topic: topic.name)
def test_we_read_the_bytes_of_the_protobuf_library(topic: Topic, maker: Maker) -> None:
    record = maker(topic, 0, np.random.default_rng(3))
    values = {
        name: np.ravel(getattr(record, name)).tolist() if column.shape else getattr(record, name)
        for name, column in columns_of(topic.record).items()
        if column.scalar != "string"
    }
    texts = {
        name: getattr(record, name) for name, c in columns_of(topic.record).items() if c.scalar == "string"
    }
    rows = {"rows": len(record.t_ns)} if topic.name.startswith("/robot/") else {}
    data = library_class(topic)(**values, **texts, **rows).SerializeToString()
    assert_equal(codec_for(topic).decode(memoryview(data), 0), record)


def test_transforms_follow_foxglove_schema(maker: Maker) -> None:
    record: Transforms = maker(TRANSFORMS, 42, np.random.default_rng(4))
    message: Any = library_class(TRANSFORMS).FromString(codec_for(TRANSFORMS).encode(record, UTC_NS))
    assert len(message.transforms) == len(record.children)
    for index, item in enumerate(message.transforms):
        assert item.timestamp.seconds * 10**9 + item.timestamp.nanos == UTC_NS
        assert (item.parent_frame_id, item.child_frame_id) == (record.parents[index], record.children[index])
        xyz = (item.translation.x, item.translation.y, item.translation.z)
        wxyz = (item.rotation.w, item.rotation.x, item.rotation.y, item.rotation.z)
        assert xyz == tuple(record.p_parent_child_m[index])
        assert wxyz == tuple(record.q_parent_child_wxyz[index])
    again = codec_for(TRANSFORMS).decode(memoryview(message.SerializeToString()), 42)
    assert_equal(again, record)


def test_joint_states_follow_foxglove_schema() -> None:
    record = JointStates(t_ns=5, names=("index_pip", "thumb_ip"), positions_rad=np.array([0.0, 0.7]))
    message: Any = library_class(HAND_JOINTS).FromString(codec_for(HAND_JOINTS).encode(record, UTC_NS))
    assert [(joint.name, joint.position) for joint in message.joints] == [
        ("index_pip", 0.0),
        ("thumb_ip", 0.7),
    ]
    assert not message.joints[0].HasField("velocity")
    message.joints[1].ClearField("position")
    again = codec_for(HAND_JOINTS).decode(memoryview(message.SerializeToString()), 5)
    np.testing.assert_array_equal(again.positions_rad, [0.0, np.nan])


def test_gaps_and_signed_zero_survive(maker: Maker) -> None:
    record: MarkerFrame = maker(MARKERS, 1, np.random.default_rng(5))
    record.p_camera_m[3] = np.nan
    record.p_camera_m[4] = -0.0
    codec = codec_for(MARKERS)
    again = codec.decode(memoryview(codec.encode(record, UTC_NS)), 1)
    assert again.p_camera_m.tobytes() == record.p_camera_m.tobytes()


def test_empty_rows_keep_their_columns() -> None:
    codec = codec_for(MARKERS)
    nothing = MarkerFrame(
        t_ns=3,
        p_camera_m=np.zeros((0, 3)),
        covariance_m2=np.zeros((0, 3, 3)),
        status=np.zeros(0, np.uint8),
        pixel_px=np.zeros((0, 2)),
        similarity=np.zeros(0),
    )
    assert_equal(codec.decode(memoryview(codec.encode(nothing, UTC_NS)), 3), nothing)


def test_a_wrong_shape_is_refused_by_name(maker: Maker) -> None:
    record: MarkerFrame = maker(MARKERS, 1, np.random.default_rng(6))
    crooked = MarkerFrame(
        t_ns=1,
        p_camera_m=record.p_camera_m[:, :2],
        covariance_m2=record.covariance_m2,
        status=record.status,
        pixel_px=record.pixel_px,
        similarity=record.similarity,
    )
    with pytest.raises(Refused, match="p_camera_m"):
        codec_for(MARKERS).encode(crooked, UTC_NS)


def test_rows_of_different_length_are_refused(maker: Maker) -> None:
    record: MarkerFrame = maker(MARKERS, 1, np.random.default_rng(6))
    crooked = MarkerFrame(
        t_ns=1,
        p_camera_m=record.p_camera_m[:4],
        covariance_m2=record.covariance_m2,
        status=record.status,
        pixel_px=record.pixel_px,
        similarity=record.similarity,
    )
    with pytest.raises(Refused, match="one length"):
        codec_for(MARKERS).encode(crooked, UTC_NS)


@pytest.mark.parametrize("topic", TOPICS.values(), ids=lambda topic: topic.name)
def test_every_cut_of_a_message_is_damage_or_a_record(topic: Topic, maker: Maker) -> None:
    codec = codec_for(topic)
    data = codec.encode(maker(topic, 1, np.random.default_rng(8)), UTC_NS)
    for end in np.unique(np.linspace(0, len(data) - 1, 200).astype(int)):
        try:
            codec.decode(memoryview(data[:end]), 1)
        except Damaged:
            continue


def test_schema_comments_tell_unit_and_shape() -> None:
    files = descriptor_pb2.FileDescriptorSet.FromString(codec_for(ROBOT_STATE).schema).file
    comments = [location.leading_comments for location in files[0].source_code_info.location]
    assert any("[Nm]" in comment and "(rows, rows)" in comment for comment in comments)
