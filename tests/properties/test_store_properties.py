"""Laws of the session store: whatever bytes it meets, it refuses in a sentence or tells the truth."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from sessions.errors import Refused
from sessions.records import (
    TOPICS,
    Event,
    JointStates,
    MarkerFrame,
    RobotCommandBlock,
    SessionHeader,
    Topic,
    Transforms,
    columns_of,
)
from sessions.records.topics import EVENTS, HAND_JOINTS, MARKERS, ROBOT_COMMAND, TRANSFORMS
from sessions.store import SessionReader, SessionWriter, info, recover, verify
from sessions.store.codec import codec_for
from sessions.store.container import MAGIC
from sessions.store.damage import Damaged
from sessions.store.wire import pack_bytes, read_varint, unpack_bytes, varint

LAW = settings(deadline=None, max_examples=150, suppress_health_check=[HealthCheck.function_scoped_fixture])
HEADER = SessionHeader(
    session_id="f" * 32,
    kind="take",
    subject_id="p",
    side="right",
    exercise="e",
    source="s",
    software_version="0",
    utc_start_ns=10**18,
    monotonic_start_ns=0,
)


def records(index: int) -> Iterator[tuple[Topic, Any]]:
    t_ns = index * 300_000_000
    row = np.full((3, 2), float(index))
    kinds = {name: row for name, column in columns_of(RobotCommandBlock).items() if len(column.shape) == 2}
    yield ROBOT_COMMAND, RobotCommandBlock(t_ns=t_ns + np.arange(3), **kinds)
    yield HAND_JOINTS, JointStates(t_ns=t_ns, names=("a", "b"), positions_rad=row[0])
    text = "ü" * index
    yield (
        EVENTS,
        Event(
            t_ns=t_ns,
            kind="note",
            severity="",
            cause=text,
            category="",
            subject="",
            value=1.0,
            bound=2.0,
            text="",
        ),
    )


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    path = tmp_path_factory.mktemp("whole") / "a.mcap"
    with SessionWriter(path, HEADER) as writer:
        for index in range(4):
            for topic, record in records(index):
                writer.write(topic, record)
        writer.seal()
    return path.read_bytes()


def everything(path: Path) -> dict[str, list[bytes]]:
    """All records of a file, encoded again, by topic; reads by record and by column."""
    with SessionReader(path) as reader:
        reader.overview()
        found: dict[str, list[bytes]] = {}
        for name, topic in TOPICS.items():
            reader.columns(topic)
            met = [codec_for(topic).encode(record, 0) for record in reader.records(topic)]
            if met:
                found[name] = met
        return found


def read_or_refuse(content: bytes) -> dict[str, list[bytes]] | None:
    """What can be read of a file with this content; None where it is refused."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "a.mcap"
        path.write_bytes(content)
        for action in (info, verify, recover):
            try:
                action(path)
            except Refused:
                continue
        try:
            return everything(path)
        except Refused:
            return None


@LAW
@given(st.binary(max_size=400))
def test_random_bytes_are_refused(content: bytes) -> None:
    assert read_or_refuse(content) is None


@LAW
@given(st.binary(max_size=400), st.booleans())
def test_random_bytes_after_the_magic_are_refused(content: bytes, ends: bool) -> None:
    assert read_or_refuse(MAGIC + content + (MAGIC if ends else b"")) is None


@LAW
@given(data=st.data())
def test_every_cut_is_refused(whole: bytes, data: st.DataObject) -> None:
    end = data.draw(st.integers(0, len(whole) - 1))
    assert read_or_refuse(whole[:end]) is None


@LAW
@given(data=st.data())
def test_a_flipped_bit_is_refused_or_harmless(whole: bytes, data: st.DataObject, tmp_path: Path) -> None:
    place = data.draw(st.integers(0, 8 * len(whole) - 1))
    content = bytearray(whole)
    content[place // 8] ^= 1 << place % 8
    met = read_or_refuse(bytes(content))
    path = tmp_path / "whole.mcap"
    path.write_bytes(whole)
    assert met is None or met == everything(path)


@LAW
@given(data=st.data())
def test_verify_misses_no_flipped_bit(whole: bytes, data: st.DataObject, tmp_path: Path) -> None:
    place = data.draw(st.integers(0, 8 * len(whole) - 1))
    content = bytearray(whole)
    content[place // 8] ^= 1 << place % 8
    path = tmp_path / "flipped.mcap"
    path.write_bytes(content)
    with pytest.raises(Refused):
        verify(path)


@LAW
@given(data=st.data(), patch=st.binary(min_size=1, max_size=30))
def test_overwritten_stretches_are_refused_or_harmless(
    whole: bytes, data: st.DataObject, patch: bytes, tmp_path: Path
) -> None:
    place = data.draw(st.integers(0, len(whole) - len(patch)))
    content = whole[:place] + patch + whole[place + len(patch) :]
    assume(content != whole)
    met = read_or_refuse(content)
    path = tmp_path / "whole.mcap"
    path.write_bytes(whole)
    assert met is None or met == everything(path)


@LAW
@given(st.sampled_from(list(TOPICS.values())), st.binary(max_size=200))
def test_random_messages_are_damage_or_records(topic: Topic, content: bytes) -> None:
    codec = codec_for(topic)
    try:
        record = codec.decode(memoryview(content), 1)
    except Damaged:
        return
    assert isinstance(record, topic.record)


@LAW
@given(st.integers(0, 2**70 - 1))
def test_varints_come_back(value: int) -> None:
    data = varint(value)
    assert read_varint(memoryview(data), 0) == (value, len(data))


@LAW
@given(arrays.arrays(np.uint8, st.integers(0, 300)))
def test_small_integers_come_back(values: np.ndarray[Any, np.dtype[np.uint8]]) -> None:
    packed = pack_bytes(values)
    assert packed == b"".join(varint(int(value)) for value in values)
    np.testing.assert_array_equal(unpack_bytes(packed), values)


FLOATS = st.floats(width=64)


@LAW
@given(count=st.integers(0, 12), data=st.data())
def test_markers_come_back(count: int, data: st.DataObject) -> None:
    def draw(*shape: int, width: int = 64) -> Any:
        elements = st.floats(width=32) if width == 32 else FLOATS
        return data.draw(arrays.arrays(np.float64, (count, *shape), elements=elements))

    record = MarkerFrame(
        t_ns=data.draw(st.integers(-(2**63), 2**63 - 1)),
        p_camera_m=draw(3),
        covariance_m2=draw(3, 3, width=32),
        status=data.draw(arrays.arrays(np.uint8, count)),
        pixel_px=draw(2),
        similarity=draw(width=32),
    )
    again = codec_for(MARKERS).decode(memoryview(codec_for(MARKERS).encode(record, 0)), 0)
    for name in columns_of(MarkerFrame):
        np.testing.assert_array_equal(getattr(again, name), getattr(record, name))


@LAW
@given(st.lists(st.tuples(st.text(), st.text(), *[FLOATS] * 7), max_size=6), st.integers(0, 2**63 - 1))
def test_transforms_come_back(rows: list[tuple[Any, ...]], utc_ns: int) -> None:
    numbers = np.array([row[2:] for row in rows], dtype=np.float64).reshape(-1, 7)
    record = Transforms(
        t_ns=9,
        parents=tuple(row[0] for row in rows),
        children=tuple(row[1] for row in rows),
        p_parent_child_m=numbers[:, :3],
        q_parent_child_wxyz=numbers[:, 3:],
    )
    codec = codec_for(TRANSFORMS)
    again = codec.decode(memoryview(codec.encode(record, utc_ns)), 9)
    for name in columns_of(Transforms):
        np.testing.assert_array_equal(np.asarray(getattr(again, name)), np.asarray(getattr(record, name)))
