"""From a sealed file to the report: the reader, the metrics and the rendering together."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rehab_app.access import CONSOLE
from rehab_app.bootstrap import open_clinic
from sessions.catalogue import TherapySession
from sessions.errors import Refused
from sessions.metrics import measure, measure_file
from sessions.records import ROWS, columns_of
from sessions.records.topics import PHASE, ROBOT_STATE, TOPICS
from sessions.reports import build_report, render_html, render_json
from sessions.reports.recompute import verify_report
from sessions.store import SessionReader, SessionWriter

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
def test_reading_in_one_pass_changes_no_number(
    kind: str, make_take: Make, make_session: Make, tmp_path: Path
) -> None:
    path = write(make_take() if kind == "take" else make_session(stopped=True), tmp_path / "session.mcap")
    ahead = measure_file(path)
    with SessionReader(path) as reader:
        plain = measure(Plain(reader.header, ahead.sha256, reader.counts, reader.columns))
    assert repr(ahead.metrics) == repr(plain.metrics)
    assert ahead.stops == plain.stops


@dataclass(frozen=True)
class Plain:
    """The reader's own columns, topic by topic."""

    header: Any
    sha256: str
    counts: Any
    columns: Any


def of_mode(make_session: Make, mode: str, name: str, factor: float = 1.0, **changes: Any) -> Any:
    """A session in which the robot's torque is that of the passive one times a factor."""
    session = make_session()
    session.topics[PHASE.name]["mode"] = np.array([mode] * len(session.topics[PHASE.name]["t_ns"]))
    session.topics[ROBOT_STATE.name]["tau_interaction_nm"] *= factor
    session.header = replace(session.header, session_id=name * 32, **changes)
    return session


@pytest.fixture
def day(make_session: Make, tmp_path: Path) -> dict[str, Path]:
    """An assistive session, and passive runs of the same day: of the other hand, and of this one."""
    rows = (
        ("assistive", "a", -1.0, {}),
        ("passive", "b", 1.0, {"side": "left"}),
        ("passive", "c", 1.0, {}),
    )
    return {
        name: write(of_mode(make_session, mode, name, factor, **changes), tmp_path / f"{name}.mcap")
        for mode, name, factor, changes in rows
    }


def test_the_days_passive_run_is_taken_off_and_the_report_is_made_again(day: dict[str, Path]) -> None:
    path, runs = day["a"], (day["a"].with_name("absent.mcap"), day["b"], day["c"])
    alone = build_report([path])
    assert "not separable" in status(alone, "work_share")
    assert "not separable" in status(alone, "robot_share")
    report = build_report([path], passive={path: runs})
    assert report.summaries[0].passive_sha256 == hashlib.sha256(day["c"].read_bytes()).hexdigest()
    for name in ("work_share", "robot_share"):
        found = report.summaries[0].metric(name)
        assert found is not None
        assert found.value < 0.9
        assert report.summaries[0].passive_sha256 in found.lineage.conditions
    assert all(one.robot_share < 0.9 for one in report.summaries[0].repetitions)
    written = path.with_name("report.json")
    written.write_bytes(render_json(report))
    assert verify_report(written, path).numbers == len(report.summaries[0].metrics)
    day["c"].rename(day["c"].with_name("moved"))
    with pytest.raises(Refused, match="beside the session"):
        verify_report(written, path)


def status(report: Any, name: str) -> str:
    found = report.summaries[0].metric(name)
    return found.status if found else ""


def test_the_clinic_finds_the_passive_run_of_the_day(day: dict[str, Path], tmp_path: Path) -> None:
    with open_clinic(tmp_path / "clinic") as clinic:
        patient = clinic.patients.add(
            CONSOLE, given_name="Ada", family_name="Lind", birth_date="1960-02-29", side="right"
        ).id
        assert patient == "P-0001"  # as in the files
        first = entered(clinic, day["a"], patient, "assistive", 0)
        before = clinic.progress.of_patient(patient).pasts[0]
        assert before.value("work_share") != before.value("work_share")
        for number, name in ((1, "b"), (2, "c")):
            entered(clinic, day[name], patient, "passive", number)
        found = {past.session_id: past for past in clinic.progress.of_patient(patient).pasts}
        assert found[first].value("work_share") < 0.9
        assert (
            found[first] == {one.session_id: one for one in clinic.progress.of_patient(patient).pasts}[first]
        )
        content = json.loads(clinic.reports.json(first))
        assert content["sessions"][0]["passive_run_sha256"] == digest(day["c"])


def entered(clinic: Any, path: Path, patient: str, mode: str, number: int) -> str:
    target = clinic.folder / "sessions" / path.name
    target.parent.mkdir(exist_ok=True)
    target.write_bytes(path.read_bytes())
    return clinic.catalogue.add_session(
        TherapySession(
            patient=patient,
            sha256=digest(path),
            path=f"sessions/{path.name}",
            mode=mode,
            started_utc_ns=1_790_000_000_000_000_000 + number,
        )
    ).id


def digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()
