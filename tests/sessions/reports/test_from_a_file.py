"""From a sealed file to the report: the reader, the metrics and the rendering together."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from sessions.errors import Refused
from sessions.metrics import measure, measure_file
from sessions.records import ROWS, columns_of
from sessions.records.topics import TOPICS
from sessions.reports import build_report, render_html, render_json
from sessions.reports.recompute import verify_report
from sessions.store import SessionWriter

Make = Callable[..., Any]


def blank(kind: Any, rows: int) -> Any:
    """A value for a column that the recording in memory does not carry."""
    shape = tuple(rows if size == ROWS else size for size in kind.shape)
    if kind.scalar == "string":
        return "" if not shape else ("",) * rows
    value = np.zeros(shape, dtype=np.dtype(kind.scalar))
    return value if shape else value.item()


def write(recording: Any, path: Path) -> Path:
    with SessionWriter(path, recording.header) as writer:
        for name, rows in recording.topics.items():
            topic = TOPICS[name]
            declared = columns_of(topic.record)
            block = declared["t_ns"].shape == (ROWS,)
            joints = len(recording.header.marker_names or recording.header.robot_joints)
            step = 50 if block else 1
            for start in range(0, len(rows["t_ns"]), step):
                chosen = slice(start, start + step) if block else start
                values = {
                    field: rows[field][chosen]
                    if field in rows
                    else blank_block(kind, rows, start, step, joints)
                    if block
                    else blank(kind, joints)
                    for field, kind in declared.items()
                }
                writer.write(topic, topic.record(**{k: plain(v) for k, v in values.items()}))
        writer.seal()
    return path


def blank_block(kind: Any, rows: Any, start: int, step: int, joints: int) -> Any:
    ticks = len(rows["t_ns"][start : start + step])
    return np.zeros((ticks,) if len(kind.shape) == 1 else (ticks, joints), dtype=np.dtype(kind.scalar))


def plain(value: Any) -> Any:
    return value.item() if isinstance(value, np.generic) else value


@pytest.mark.parametrize("kind", ["take", "session"])
def test_a_sealed_file_gives_the_numbers_of_its_columns(
    kind: str, make_take: Make, make_session: Make, tmp_path: Path
) -> None:
    recording = make_take() if kind == "take" else make_session(stopped=True)
    path = write(recording, tmp_path / "session.mcap")
    from_file, from_memory = measure_file(path), measure(recording)
    assert from_file.sha256 == hashlib.sha256(path.read_bytes()).hexdigest()
    assert len(from_file.metrics) == len(from_memory.metrics) > 50
    for one, other in zip(from_file.metrics, from_memory.metrics, strict=True):
        assert (one.name, one.subject, one.status) == (other.name, other.subject, other.status)
        assert one.value == pytest.approx(other.value, rel=1e-6, abs=1e-9, nan_ok=True)
    assert from_file.stops == from_memory.stops
    report = build_report([path], "0.1.0")
    assert from_file.sha256 in render_html(report)
    assert from_file.sha256.encode() in render_json(report)


def test_a_file_that_is_no_recording(tmp_path: Path) -> None:
    path = tmp_path / "notes.mcap"
    path.write_bytes(b"these are notes")
    with pytest.raises(Refused):
        build_report([path])
    with pytest.raises(Refused):
        build_report([tmp_path / "absent.mcap"])


def test_a_report_is_made_again_bit_for_bit_and_a_changed_number_is_named(
    make_session: Make, make_take: Make, tmp_path: Path
) -> None:
    path, other = write(make_session(), tmp_path / "session.mcap"), write(make_take(), tmp_path / "take.mcap")
    written = tmp_path / "report.json"
    written.write_bytes(render_json(build_report([other, path])))
    proof = verify_report(written, path)
    assert proof.numbers == len(measure_file(path).metrics)
    text = written.read_text()
    value = next(
        item for item in measure_file(path).metrics if item.name == "joint_rmse" and item.value > 0.0
    ).value
    written.write_text(text.replace(repr(value), repr(np.nextafter(value, 1.0).item())))
    with pytest.raises(Refused, match=r"value of joint_rmse \("):
        verify_report(written, path)
    verify_report(written, other)


def test_what_is_no_report_of_the_file_is_refused(
    make_take: Make, make_session: Make, tmp_path: Path
) -> None:
    path = write(make_take(), tmp_path / "take.mcap")
    written = tmp_path / "report.json"
    for content, words in ((b"{", "no JSON"), (b"[]", "without metrics"), (b'{"metrics": [1]}', "not about")):
        written.write_bytes(content)
        with pytest.raises(Refused, match=words):
            verify_report(written, path)
    with pytest.raises(Refused, match="not readable"):
        verify_report(tmp_path / "absent.json", path)


@pytest.mark.parametrize("kind", ["take", "session"])
def test_reading_ahead_changes_no_number(
    kind: str, make_take: Make, make_session: Make, tmp_path: Path
) -> None:
    path = write(make_take() if kind == "take" else make_session(stopped=True), tmp_path / "session.mcap")
    ahead = build_report([path]).summaries[0]
    plain = measure_file(path)
    assert repr(ahead.metrics) == repr(plain.metrics)
    assert (ahead.stops, ahead.sha256) == (plain.stops, plain.sha256)
