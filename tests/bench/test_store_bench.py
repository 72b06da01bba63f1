"""Our writer against the plain ``mcap`` and protobuf libraries, and how fast a long session reads back."""

from __future__ import annotations

import statistics
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from google.protobuf import descriptor_pb2, descriptor_pool, message_factory
from mcap.writer import Writer

from sessions.records import (
    JOINTS,
    LANDMARKS,
    ROWS,
    TOPICS,
    Event,
    JointStates,
    SessionHeader,
    Topic,
    Transforms,
    columns_of,
)
from sessions.records.topics import (
    EVENTS,
    HAND_JOINTS,
    HAND_POSE,
    MARKERS,
    PATIENT_POSE,
    PHASE,
    REFERENCE,
    ROBOT_COMMAND,
    ROBOT_STATE,
    TRANSFORMS,
)
from sessions.store import SessionReader, SessionWriter, verify
from sessions.store.codec import codec_for

pytestmark = pytest.mark.bench

UTC_NS = 1_790_000_000_000_000_000
SECOND_NS = 1_000_000_000
SESSION_S = 20
ROUNDS = 5
READ_S = 180
RATES_HZ = {
    TRANSFORMS: 30,
    MARKERS: 30,
    HAND_JOINTS: 30,
    HAND_POSE: 30,
    REFERENCE: 100,
    PATIENT_POSE: 100,
    PHASE: 10,
    EVENTS: 1,
    ROBOT_STATE: 20,
    ROBOT_COMMAND: 20,
}
HEADER = SessionHeader(
    session_id="0" * 32,
    kind="therapy",
    subject_id="p",
    side="right",
    exercise="e",
    source="s",
    software_version="0",
    utc_start_ns=UTC_NS,
    monotonic_start_ns=0,
)
Sample = tuple[Topic, int, Any]


def values_of(topic: Topic, t_ns: int, rng: np.random.Generator) -> dict[str, Any]:
    """Noise in the shape of every column: the worst case for compression."""
    is_block = bool(columns_of(topic.record)["t_ns"].shape)
    rows = 50 if is_block else 25
    values: dict[str, Any] = {}
    for name, column in columns_of(topic.record).items():
        shape = tuple((12 if index else rows) if n == ROWS else n for index, n in enumerate(column.shape))
        if column.scalar == "string":
            values[name] = "passive"
        elif column.scalar == "uint8":
            values[name] = np.full(shape, 2, np.uint8)
        else:
            values[name] = rng.normal(size=shape) if shape else 1.5
    values["t_ns"] = t_ns + np.arange(50) * 1_000_000 if is_block else t_ns
    return values | ({"repetition": 3} if topic is PHASE else {})


def record_of(topic: Topic, t_ns: int, rng: np.random.Generator) -> Any:
    if topic is TRANSFORMS:
        names = tuple(f"{who}/{name}" for who in ("reference", "patient") for name in ("palm", *LANDMARKS))
        return Transforms(
            t_ns=t_ns,
            parents=("camera",) * len(names),
            children=names,
            p_parent_child_m=rng.normal(size=(len(names), 3)),
            q_parent_child_wxyz=rng.normal(size=(len(names), 4)),
        )
    if topic is HAND_JOINTS:
        return JointStates(t_ns=t_ns, names=JOINTS, positions_rad=rng.normal(size=21))
    if topic is EVENTS:
        texts = {"severity": "info", "cause": "x", "category": "", "subject": "", "text": "A note."}
        return Event(t_ns=t_ns, kind="note", value=1.0, bound=2.0, **texts)
    return topic.record(**values_of(topic, t_ns, rng))


@pytest.fixture(scope="module")
def session() -> list[Sample]:
    """A therapy session's records in the order in which they come."""
    rng = np.random.default_rng(3)
    samples = [
        (topic, index * SECOND_NS // rate, None)
        for topic, rate in RATES_HZ.items()
        for index in range(SESSION_S * rate)
    ]
    samples.sort(key=lambda sample: sample[1])
    return [(topic, t_ns, record_of(topic, t_ns, rng)) for topic, t_ns, _ in samples]


def write_ours(path: Path, session: list[Sample]) -> None:
    with SessionWriter(path, HEADER) as writer:
        for topic, _, record in session:
            writer.write(topic, record)
        writer.seal()


def filled(message: Any, topic: Topic, record: Any) -> Any:
    """A record put into a protobuf message, in the way that suits the library best."""
    if topic is TRANSFORMS:
        seconds, nanos = divmod(UTC_NS + record.t_ns, SECOND_NS)
        numbers = np.hstack((record.p_parent_child_m, record.q_parent_child_wxyz)).tolist()
        for parent, child, row in zip(record.parents, record.children, numbers, strict=True):
            item = message.transforms.add(parent_frame_id=parent, child_frame_id=child)
            item.timestamp.seconds, item.timestamp.nanos = seconds, nanos
            item.translation.x, item.translation.y, item.translation.z = row[:3]
            item.rotation.w, item.rotation.x, item.rotation.y, item.rotation.z = row[3:]
        return message
    if topic is HAND_JOINTS:
        message.timestamp.seconds, message.timestamp.nanos = divmod(UTC_NS + record.t_ns, SECOND_NS)
        for name, position in zip(record.names, record.positions_rad.tolist(), strict=True):
            message.joints.add(name=name, position=position)
        return message
    for name, column in columns_of(topic.record).items():
        value = getattr(record, name)
        if column.shape and column.scalar != "string":
            getattr(message, name).extend(value.ravel().tolist())
        else:
            setattr(message, name, value)
    return message


def write_plain(path: Path, session: list[Sample]) -> None:
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start()
        channels: dict[str, int] = {}
        classes: dict[str, Any] = {}
        for topic in TOPICS.values():
            schema = codec_for(topic).schema
            pool = descriptor_pool.DescriptorPool()
            for file in descriptor_pb2.FileDescriptorSet.FromString(schema).file:
                pool.Add(file)
            classes[topic.name] = message_factory.GetMessageClass(pool.FindMessageTypeByName(topic.schema))
            schema_id = writer.register_schema(topic.schema, "protobuf", schema)
            channels[topic.name] = writer.register_channel(topic.name, "protobuf", schema_id)
        for topic, t_ns, record in session:
            data = filled(classes[topic.name](), topic, record).SerializeToString()
            writer.add_message(channels[topic.name], UTC_NS + t_ns, data, UTC_NS + t_ns)
        writer.finish()


def timed(action: Callable[[], Any]) -> float:
    start = time.perf_counter()
    action()
    return time.perf_counter() - start


def test_writing_costs_no_more_than_the_plain_libraries(session: list[Sample], tmp_path: Path) -> None:
    ours, plain = [], []
    for index in range(ROUNDS):
        ours.append(timed(lambda at=tmp_path / f"ours{index}.mcap": write_ours(at, session)))
        plain.append(timed(lambda at=tmp_path / f"plain{index}.mcap": write_plain(at, session)))
    ratio = statistics.median(ours) / statistics.median(plain)
    sizes = [(tmp_path / f"{name}0.mcap").stat().st_size / 1e6 for name in ("ours", "plain")]
    report = (
        f"writing {SESSION_S} s of therapy, {len(session)} records: ours {statistics.median(ours):.3f} s"
        f" ({sizes[0]:.1f} MB), plain {statistics.median(plain):.3f} s ({sizes[1]:.1f} MB), ratio {ratio:.2f}"
    )
    show(report)
    assert ratio <= 1.0


def test_long_robot_blocks_read_back(tmp_path: Path) -> None:
    rng = np.random.default_rng(4)
    path = tmp_path / "long.mcap"
    with SessionWriter(path, HEADER) as writer:
        for index in range(READ_S * 20):
            t_ns = index * 50_000_000
            writer.write(ROBOT_STATE, record_of(ROBOT_STATE, t_ns, rng))
        writer.seal()
    times: dict[str, float] = {}
    with SessionReader(path) as reader:
        for name, fields in {"all fields": None, "q_rad": ("q_rad",)}.items():
            start = time.perf_counter()
            columns = reader.columns(ROBOT_STATE, names=fields)
            times[name] = time.perf_counter() - start
            assert columns.rows == READ_S * 1000
        times["records"] = timed(lambda: sum(1 for _ in reader.records(ROBOT_STATE)))
        times["overview"] = timed(reader.overview)
    times["verify"] = timed(lambda: verify(path))
    size = path.stat().st_size / 1e6
    figures = ", ".join(f"{name} {value:.3f} s" for name, value in times.items())
    show(f"reading {READ_S} s of 1 kHz robot state, 12 joints ({size:.0f} MB): {figures}; x10 for 30 minutes")


def show(text: str) -> None:
    """Put a figure where a person who runs the benchmarks sees it."""
    sys.stderr.write(f"\n{text}\n")
