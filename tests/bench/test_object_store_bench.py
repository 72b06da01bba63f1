"""The first look at a session of an hour in an object store: how long, and what share of its bytes."""

from __future__ import annotations

import hashlib
import sys
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from sessions.records import SessionHeader, Topic, columns_of
from sessions.records.topics import HAND_POSE, PATIENT_POSE, REFERENCE, ROBOT_STATE
from sessions.store import SessionReader, SessionWriter
from sessions.store.object_source import ObjectSource
from sessions.store.object_store import ObjectPlace, ObjectStore

pytestmark = pytest.mark.bench

SECOND_NS = 1_000_000_000
SESSION_S = 3600
BLOCK_ROWS = 50
RATES_HZ = {HAND_POSE: 30, REFERENCE: 100, PATIENT_POSE: 100, ROBOT_STATE: 1}
"""A twentieth of the robot's rows: a real hour is longer, and the share of a first look in it smaller."""
SHARE_MAX = 0.05
FIRST_LOOK_S = 2.0
HEADER = SessionHeader(
    session_id="0" * 32,
    kind="therapy",
    subject_id="p",
    side="right",
    exercise="e",
    source="s",
    software_version="0",
    utc_start_ns=1_790_000_000_000_000_000,
    monotonic_start_ns=0,
)


def record_of(topic: Topic, rng: np.random.Generator) -> Any:
    """Values with the steps of an encoder, so that they pack about as well as real ones."""
    values: dict[str, Any] = {}
    for name, column in columns_of(topic.record).items():
        shape = tuple(BLOCK_ROWS if size < 0 or size == 0 else size for size in column.shape)
        whole = column.scalar in ("uint8", "uint16", "int64")
        number = np.full(shape, 2, column.scalar) if whole else np.round(rng.normal(size=shape), 4)
        values[name] = "x" if column.scalar == "string" else (number if shape else number.item())
    return topic.record(**values)


def write_hour(path: Path) -> None:
    rng = np.random.default_rng(3)
    ready = {topic: [record_of(topic, rng) for _ in range(30)] for topic in RATES_HZ}
    block = np.arange(BLOCK_ROWS) * (SECOND_NS // 1000)
    steps = sorted(
        (index * SECOND_NS // rate, topic.name, index)
        for topic, rate in RATES_HZ.items()
        for index in range(SESSION_S * rate)
    )
    topics = {topic.name: topic for topic in RATES_HZ}
    with SessionWriter(path, HEADER) as writer:
        for t_ns, name, index in steps:
            topic = topics[name]
            t = t_ns + block if columns_of(topic.record)["t_ns"].shape else t_ns
            writer.write(topic, replace(ready[topic][index % 30], t_ns=t))
        writer.attach_overview(b"{}")
        writer.seal()


def test_first_look_at_an_hour(tmp_path: Path, s3: Any) -> None:
    path = tmp_path / "hour.mcap"
    write_hour(path)
    place = ObjectPlace("clinic-bucket", endpoint=s3.behind.geturl(), access_key="k", secret_key="s")
    store = ObjectStore(place)
    with path.open("rb") as file:
        key = place.key("sessions", hashlib.file_digest(file, "sha256").hexdigest())
    store.put(path, key)
    begun = time.perf_counter()
    with SessionReader(path) as reader:
        assert reader.overview() is not None
    local_s = time.perf_counter() - begun
    begun = time.perf_counter()
    store.read(key, 0, 1)
    answer_s = time.perf_counter() - begun
    begun = time.perf_counter()
    source = ObjectSource(store, key)
    with SessionReader(path, source) as reader:
        seen = reader.overview(), reader.counts, reader.span_ns()
    took_s = time.perf_counter() - begun
    share = source.fetched_bytes / source.size
    sys.stdout.write(
        f"\nfirst look at {source.size / 1e6:.0f} MB: {took_s:.2f} s (at most {FIRST_LOOK_S}), "
        f"{100 * share:.2f} % of its bytes (at most {100 * SHARE_MAX:.0f}), {source.requests} requests\n"
        f"of which from the disk {local_s:.2f} s, and this server takes {answer_s:.2f} s for one byte\n"
    )
    assert seen[0] is not None
    assert share <= SHARE_MAX
