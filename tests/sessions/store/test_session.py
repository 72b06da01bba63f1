from __future__ import annotations

import errno
import hashlib
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from sessions.errors import Refused
from sessions.records import TOPICS, SessionHeader, Topic, columns_of
from sessions.records.topics import EVENTS, HAND_POSE, MARKERS, PHASE, ROBOT_STATE
from sessions.store import SessionReader, SessionWriter, info, partials, recover, verify
from sessions.store.diskfile import HashedFile
from sessions.timebase import Timebase

START_NS = 5_000_000_000
PERIOD_NS = 50_000_000
Maker = Callable[[Topic, int, np.random.Generator], Any]


def same(met: Any, expected: Any) -> bool:
    return all(
        np.array_equal(np.asarray(getattr(met, name)), np.asarray(getattr(expected, name)))
        for name in columns_of(type(expected))
    )


def test_what_was_written_is_read(sealed: Path, header: SessionHeader, written: dict[str, list[Any]]) -> None:
    with SessionReader(sealed) as reader:
        assert reader.header == header
        assert reader.counts == {name: 40 for name in TOPICS}
        for name, records in written.items():
            met = list(reader.records(TOPICS[name]))
            assert len(met) == len(records)
            assert all(same(one, other) for one, other in zip(met, records, strict=True))
        assert list(reader.events()) == written["/events"]


@pytest.mark.parametrize("topic", TOPICS.values(), ids=lambda topic: topic.name)
def test_columns_are_the_records_laid_along_time(
    topic: Topic, sealed: Path, written: dict[str, list[Any]]
) -> None:
    with SessionReader(sealed) as reader:
        columns = reader.columns(topic)
    is_block = bool(columns_of(topic.record)["t_ns"].shape)
    assert set(columns) == set(columns_of(topic.record))
    for name in columns:
        values = [np.asarray(getattr(record, name)) for record in written[topic.name]]
        expected = np.concatenate(values) if is_block else np.stack(values)
        np.testing.assert_array_equal(columns[name], expected)
        assert not columns[name].flags.writeable


@pytest.mark.parametrize("topic", [HAND_POSE, ROBOT_STATE], ids=lambda topic: topic.name)
@pytest.mark.parametrize(("start", "end"), [(0.21, 0.93), (-1, 0.2), (1.9, 9), (3, 4), (0.5, 0.5)])
def test_a_time_range_is_cut_exactly(topic: Topic, start: float, end: float, sealed: Path) -> None:
    start_ns, end_ns = START_NS + int(start * 1e9), START_NS + int(end * 1e9)
    with SessionReader(sealed) as reader:
        whole = reader.columns(topic)
        part = reader.columns(topic, start_ns, end_ns)
        keep = (whole.t_ns >= start_ns) & (whole.t_ns < end_ns)
        assert part.rows == np.count_nonzero(keep)
        for name in whole if part.rows else ():
            np.testing.assert_array_equal(part[name], whole[name][keep])
        records = list(reader.records(topic, start_ns, end_ns))
    assert sum(np.size(record.t_ns) for record in records) >= part.rows


def test_fields_can_be_chosen(sealed: Path) -> None:
    with SessionReader(sealed) as reader:
        assert set(reader.columns(ROBOT_STATE, names=("q_rad",))) == {"t_ns", "q_rad"}
        with pytest.raises(Refused, match="q_deg"):
            reader.columns(ROBOT_STATE, names=("q_deg",))


def test_a_topic_that_is_absent_is_empty(tmp_path: Path, header: SessionHeader) -> None:
    with SessionWriter(tmp_path / "bare.mcap", header) as writer:
        writer.seal()
    with SessionReader(tmp_path / "bare.mcap") as reader:
        assert list(reader.records(HAND_POSE)) == []
        assert reader.columns(HAND_POSE)["fingertips_palm_m"].shape == (0, 5, 3)
        assert reader.columns(ROBOT_STATE)["q_rad"].shape == (0, 0)
        assert reader.span_ns() is None
    assert info(tmp_path / "bare.mcap").duration_s == 0
    assert verify(tmp_path / "bare.mcap").records == {}


def test_the_file_is_named_and_hashed_when_sealed(sealed: Path) -> None:
    digest = hashlib.sha256(sealed.read_bytes()).hexdigest()
    assert sealed.with_name("walk.mcap.sha256").read_text() == f"{digest}  walk.mcap\n"
    assert sorted(path.name for path in sealed.parent.iterdir()) == ["walk.mcap", "walk.mcap.sha256"]
    proof = verify(sealed)
    assert proof.sha256 == digest
    assert proof.digest_noted
    assert proof.records == {name: 40 for name in TOPICS}


def test_info_tells_what_is_there(sealed: Path, header: SessionHeader) -> None:
    told = info(sealed)
    assert told.header == header
    assert told.duration_s == pytest.approx(1.95 + 0.049)
    assert {topic.name: topic.schema for topic in told.topics} == {t.name: t.schema for t in TOPICS.values()}
    assert told.has_overview
    assert not told.recovered


def test_log_time_is_utc(sealed: Path, header: SessionHeader) -> None:
    with SessionReader(sealed) as reader:
        span = reader.span_ns()
        statistics = reader.summary.statistics[0]
    timebase = Timebase(header.utc_start_ns, header.monotonic_start_ns)
    assert span is not None
    assert statistics.message_start_time == timebase.to_utc_ns(START_NS) == header.utc_start_ns
    assert span[1] == timebase.to_monotonic_ns(statistics.message_end_time)


def test_the_overview_is_ten_hertz(sealed: Path, written: dict[str, list[Any]]) -> None:
    with SessionReader(sealed) as reader:
        overview = reader.overview()
    assert overview is not None
    poses = overview.series["/hand/pose"]
    np.testing.assert_array_equal(np.diff(poses.t_ns), 100_000_000)
    expected = np.array([record.fingertips_palm_m for record in written["/hand/pose"][::2]])
    np.testing.assert_allclose(poses.columns["fingertips_palm_m"], expected, atol=1e-5)
    assert overview.events == tuple(written["/events"])
    assert overview.metrics == b'{"rmse_rad": 0.02}'


def test_the_overview_of_an_hour_stays_small(tmp_path: Path, header: SessionHeader, maker: Maker) -> None:
    phase = maker(PHASE, START_NS, np.random.default_rng(1))
    with SessionWriter(tmp_path / "hour.mcap", header) as writer:
        for index in range(20_000):
            writer.write(PHASE, type(phase)(**{**_fields(phase), "t_ns": START_NS + index * 180_000_000}))
        writer.seal()
    with SessionReader(tmp_path / "hour.mcap") as reader:
        overview = reader.overview()
    assert overview is not None
    assert 1000 < len(overview.series["/therapy/phase"].t_ns) <= 4096


def _fields(record: Any) -> dict[str, Any]:
    return {name: getattr(record, name) for name in columns_of(type(record))}


@dataclass(frozen=True)
class Figures:
    rmse_rad: float


def test_gaps_in_events_and_figures_survive_the_overview(
    tmp_path: Path, header: SessionHeader, maker: Maker
) -> None:
    event = maker(EVENTS, START_NS, np.random.default_rng(1))
    event = type(event)(**{**_fields(event), "value": float("nan")})
    with SessionWriter(tmp_path / "a.mcap", header) as writer:
        writer.write(EVENTS, event)
        writer.attach_overview(Figures(0.5))
        writer.seal()
    with SessionReader(tmp_path / "a.mcap") as reader:
        overview = reader.overview()
    assert overview is not None
    assert np.isnan(overview.events[0].value)
    assert overview.metrics == b'{"rmse_rad":0.5}'


def test_an_exception_leaves_only_the_partial_file(
    tmp_path: Path, header: SessionHeader, maker: Maker
) -> None:
    path = tmp_path / "walk.mcap"
    record = maker(HAND_POSE, START_NS, np.random.default_rng(1))

    def interrupted() -> None:
        with SessionWriter(path, header) as writer:
            writer.write(HAND_POSE, record)
            assert partials(tmp_path) == ()
            raise RuntimeError

    with pytest.raises(RuntimeError):
        interrupted()
    assert [item.name for item in tmp_path.iterdir()] == ["walk.partial.mcap"]
    assert partials(tmp_path) == (tmp_path / "walk.partial.mcap",)
    found = recover(tmp_path / "walk.partial.mcap")
    assert found.records == 1
    with SessionReader(path) as reader:
        assert same(next(reader.records(HAND_POSE)), record)
        assert reader.metadata("recovery") == {"records": "1", "lost_records": "0", "lost_chunks": "0"}
    assert info(path).recovered


def test_a_recording_under_way_is_not_recovered(tmp_path: Path, header: SessionHeader) -> None:
    with SessionWriter(tmp_path / "a.mcap", header) as writer:
        with pytest.raises(Refused, match="being recorded"):
            recover(writer.partial)
        with pytest.raises(Refused, match="partial session"):
            SessionWriter(tmp_path / "a.mcap", header)


def test_nothing_is_overwritten(sealed: Path, tmp_path: Path, header: SessionHeader) -> None:
    path = tmp_path / "walk.mcap"
    shutil.copy(sealed, path)
    before = path.read_bytes()
    with pytest.raises(Refused, match="exists"):
        SessionWriter(path, header)
    path.unlink()
    with SessionWriter(path, header) as writer:
        path.write_bytes(before)
        with pytest.raises(Refused, match="exists"):
            writer.seal()
    assert path.read_bytes() == before


@pytest.mark.parametrize("name", ["walk.bag", "walk.partial.mcap", ".mcap", "absent/walk.mcap"])
def test_an_unfit_path_is_refused(name: str, tmp_path: Path, header: SessionHeader) -> None:
    with pytest.raises(Refused):
        SessionWriter(tmp_path / name, header)
    assert list(tmp_path.iterdir()) == []


def test_a_record_of_another_topic_is_refused(tmp_path: Path, header: SessionHeader, maker: Maker) -> None:
    rng = np.random.default_rng(1)
    with SessionWriter(tmp_path / "a.mcap", header) as writer:
        with pytest.raises(Refused, match="MarkerFrame"):
            writer.write(MARKERS, maker(HAND_POSE, START_NS, rng))
        with pytest.raises(Refused, match="record time"):
            writer.write(HAND_POSE, maker(HAND_POSE, -(2**62), rng))
        with pytest.raises(Refused, match="rising"):
            writer.write(ROBOT_STATE, _reversed(maker(ROBOT_STATE, START_NS, rng)))


def _reversed(block: Any) -> Any:
    return type(block)(**{**_fields(block), "t_ns": block.t_ns[::-1]})


def test_a_full_disk_is_a_sentence(
    tmp_path: Path, header: SessionHeader, maker: Maker, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "walk.mcap"
    real = HashedFile.write

    def full(self: HashedFile, data: bytes) -> int:
        if self.tell() > 30_000:
            raise OSError(errno.ENOSPC, "No space left on device")
        return real(self, data)

    monkeypatch.setattr(HashedFile, "write", full)
    rng = np.random.default_rng(1)
    records = [maker(HAND_POSE, START_NS + index * PERIOD_NS, rng) for index in range(200)]

    def record_all() -> None:
        with SessionWriter(path, header) as writer:
            for record in records:
                writer.write(HAND_POSE, record)

    with pytest.raises(Refused, match="no space left"):
        record_all()
    monkeypatch.undo()
    assert not path.exists()
    assert recover(tmp_path / "walk.partial.mcap").records > 5


def test_silence_is_flushed_too(tmp_path: Path, header: SessionHeader, maker: Maker) -> None:
    with SessionWriter(tmp_path / "a.mcap", header) as writer:
        before = writer.partial.stat().st_size
        writer.write(EVENTS, maker(EVENTS, START_NS, np.random.default_rng(1)))
        writer._flush_aside()  # what the side thread calls twice a second
        assert writer.partial.stat().st_size > before


def test_a_slow_block_is_found_by_any_of_its_ticks(
    tmp_path: Path, header: SessionHeader, maker: Maker
) -> None:
    block = maker(ROBOT_STATE, START_NS, np.random.default_rng(1))
    slow = type(block)(**{**_fields(block), "t_ns": START_NS + 80_000_000 * np.arange(50)})
    with SessionWriter(tmp_path / "a.mcap", header) as writer:
        writer.write(ROBOT_STATE, slow)
        writer.seal()
    with SessionReader(tmp_path / "a.mcap") as reader:
        for first, last in ((0, 3), (20, 25), (48, 50)):
            part = reader.columns(ROBOT_STATE, int(slow.t_ns[first]), int(slow.t_ns[last - 1]) + 1)
            np.testing.assert_array_equal(part["q_rad"], slow.q_rad[first:last])
