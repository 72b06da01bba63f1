"""One pass gives what many give, to the last bit; and damage is still found."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from sessions.errors import Refused
from sessions.records import Event, SessionHeader
from sessions.records.topics import EVENTS, PATIENT_POSE, PHASE, ROBOT_STATE, TRANSFORMS
from sessions.store import SessionReader, SessionWriter
from sessions.store.bulk import columns_together

UTC_NS, STEP_NS = 1_790_000_000_000_000_000, 10_000_000
WANTED = {PATIENT_POSE: None, PHASE: None, EVENTS: None, ROBOT_STATE: ("q_rad", "safety_state")}


def blocks(start_ns: int, ticks: int, joints: int, rng: np.random.Generator) -> Any:
    shape = (ticks, joints)
    numbers = {name: rng.normal(size=shape) for name in ("q_rad", "dq_rad_s", "tau_nm", "tau_interaction_nm")}
    return ROBOT_STATE.record(
        t_ns=start_ns + np.arange(ticks) * 1_000_000,
        path_s=rng.normal(size=ticks),
        path_speed=np.ones(ticks),
        safety_state=rng.integers(0, 256, ticks).astype(np.uint8),
        **numbers,
    )


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Records whose length varies: texts, short last blocks, bytes above 127."""
    rng = np.random.default_rng(11)
    made = tmp_path_factory.mktemp("bulk") / "session.mcap"
    header = SessionHeader(
        session_id="0" * 32, kind="therapy", subject_id="P-0001", side="right", exercise="e", source="s",
        software_version="0", utc_start_ns=UTC_NS, monotonic_start_ns=0,
        robot_joints=("index_pip", "middle_pip"),
    )  # fmt: skip
    with SessionWriter(made, header) as writer:
        for row in range(700):
            now = row * STEP_NS
            writer.write(
                PATIENT_POSE,
                PATIENT_POSE.record(
                    t_ns=now,
                    source=("encoder", "camera")[row % 2],
                    joints_rad=rng.normal(size=21),
                    joint_std_rad=rng.normal(size=21),
                    joint_status=rng.integers(0, 3, 21).astype(np.uint8),
                    fingertips_palm_m=rng.normal(size=(5, 3)),
                    fingertip_std_m=rng.normal(size=5),
                ),
            )
            writer.write(
                PHASE,
                PHASE.record(
                    t_ns=now, repetition=row % 3 - 1, phase=("move", "hold", "rest")[row % 3],
                    mode="passive" if row < 300 else "assistive", started_by="" if row % 5 else "patient",
                    path_s=0.1 * row, path_speed=1.0, assistance=np.full(5, np.nan),
                ),
            )  # fmt: skip
            if row % 5 == 0:
                writer.write(ROBOT_STATE, blocks(now, 50 if row % 35 else 17, 2, rng))
            if row % 100 == 0:
                writer.write(EVENTS, event(now, "a note, é" * (row // 100)))
        writer.seal()
    return made


def event(t_ns: int, text: str) -> Event:
    return Event(
        t_ns=t_ns, kind="note", severity="info", cause="x", category="", subject="", value=1.0, bound=np.nan,
        text=text,
    )  # fmt: skip


def test_one_pass_gives_what_many_give_bit_for_bit(path: Path) -> None:
    with SessionReader(path) as reader:
        together = columns_together(reader, WANTED)
        for topic, names in WANTED.items():
            alone = reader.columns(topic, names=names)
            found = together[topic.name]
            assert set(found) == set(alone)
            for name, values in alone.items():
                assert found[name].dtype == values.dtype
                assert found[name].shape == values.shape
                assert found[name].tobytes() == values.tobytes()


def test_a_topic_that_the_file_lacks_is_empty(tmp_path: Path, path: Path) -> None:
    with SessionReader(path) as reader:
        header = reader.header
    bare = tmp_path / "bare.mcap"
    with SessionWriter(bare, header) as writer:
        writer.write(EVENTS, event(0, "alone"))
        writer.seal()
    with SessionReader(bare) as reader:
        found = columns_together(reader, WANTED)
        assert [len(found[topic.name]["t_ns"]) for topic in WANTED] == [0, 0, 1, 0]
        assert found[PATIENT_POSE.name]["joints_rad"].shape == (0, 21)


def test_a_flipped_byte_is_refused(path: Path, tmp_path: Path) -> None:
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 0xFF
    damaged = tmp_path / "damaged.mcap"
    damaged.write_bytes(content)
    with pytest.raises(Refused), SessionReader(damaged) as reader:
        columns_together(reader, WANTED)


def test_foreign_schemas_are_not_for_this(path: Path) -> None:
    with SessionReader(path) as reader, pytest.raises(TypeError):
        columns_together(reader, {TRANSFORMS: None})


def test_equally_long_messages_with_their_fields_elsewhere(tmp_path: Path, path: Path) -> None:
    with SessionReader(path) as reader:
        header = reader.header
    shifted = tmp_path / "shifted.mcap"
    words = [("ab", "cdef"), ("abcd", "ef"), ("ab", "cdef"), ("", "abcdef")] * 5
    with SessionWriter(shifted, header) as writer:
        for row, (phase, started_by) in enumerate(words):
            writer.write(
                PHASE,
                PHASE.record(
                    t_ns=row, repetition=0, phase=phase, mode="m", started_by=started_by, path_s=0.0,
                    path_speed=1.0, assistance=np.zeros(5),
                ),
            )  # fmt: skip
        writer.seal()
    with SessionReader(shifted) as reader:
        found = columns_together(reader, {PHASE: None})[PHASE.name]
        assert list(zip(found["phase"], found["started_by"], strict=True)) == words
