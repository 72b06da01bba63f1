"""Random records of every topic, made from their declarations, and a small written session."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from sessions.records import ROWS, TOPICS, SessionHeader, Topic, columns_of
from sessions.records.fields import Column
from sessions.store import SessionWriter

START_NS = 5_000_000_000
UTC_NS = 1_790_000_000_123_456_789
TICK_NS = 1_000_000
ROW_COUNT = 50
Record = Any
Maker = Callable[[Topic, int, np.random.Generator], Record]


def _value(column: Column, rng: np.random.Generator) -> Any:
    shape = tuple(12 if size == ROWS and index else size for index, size in enumerate(column.shape))
    shape = tuple(ROW_COUNT if size == ROWS else size for size in shape)
    if column.scalar == "string":
        texts = [f"n{number}é" for number in rng.integers(0, 99, ROW_COUNT)]
        return tuple(texts) if shape else texts[0]
    values: NDArray[Any] = rng.normal(size=shape)
    if column.scalar == "float32":
        values = values.astype(np.float32).astype(np.float64)  # what the file can hold exactly
    if column.scalar == "int64":
        values = rng.integers(-(2**62), 2**62, size=shape)
    if column.scalar == "uint8":
        values = rng.integers(0, 256, size=shape).astype(np.uint8)
    if column.scalar == "uint16":
        values = rng.integers(0, 65536, size=shape).astype(np.uint16)
    return values if shape else np.asarray(values).item()


def make_record(topic: Topic, t_ns: int, rng: np.random.Generator) -> Record:
    columns = columns_of(topic.record)
    values = {name: _value(column, rng) for name, column in columns.items()}
    values["t_ns"] = t_ns + TICK_NS * np.arange(ROW_COUNT) if columns["t_ns"].shape else t_ns
    return topic.record(**values)


@pytest.fixture(scope="session")
def maker() -> Maker:
    return make_record


@pytest.fixture(scope="session")
def header() -> SessionHeader:
    return SessionHeader(
        session_id="0123456789abcdef" * 2,
        kind="therapy",
        subject_id="p-17",
        side="left",
        exercise="power grip, größer",
        source="virtual-camera",
        software_version="0.1.0",
        marker_names=("index_tip", "thumb_tip"),
        parents=("ab" * 32,),
        consent_images=True,
        utc_start_ns=UTC_NS,
        monotonic_start_ns=START_NS,
    )


@pytest.fixture(scope="session")
def written(header: SessionHeader) -> dict[str, list[Record]]:
    """Two seconds of every topic at 20 Hz, by topic name."""
    rng = np.random.default_rng(7)
    return {
        topic.name: [make_record(topic, START_NS + index * 50 * TICK_NS, rng) for index in range(40)]
        for topic in TOPICS.values()
    }


@pytest.fixture(scope="session")
def sealed(
    tmp_path_factory: pytest.TempPathFactory, header: SessionHeader, written: dict[str, list[Record]]
) -> Path:
    """A sealed session of ``written``, all topics interleaved; tests copy it before they harm it."""
    path = tmp_path_factory.mktemp("sealed") / "walk.mcap"
    with SessionWriter(path, header) as writer:
        for index in range(40):
            for name, records in written.items():
                writer.write(TOPICS[name], records[index])
        writer.attach_overview(b'{"rmse_rad": 0.02}')
        writer.seal()
    return path
