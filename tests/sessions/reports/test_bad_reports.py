"""Bad recordings through the command and the page: a report that says so, or one sentence; never a guess."""

from __future__ import annotations

import asyncio
import hashlib
import json
import re
import shutil
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import pytest
from typer.testing import CliRunner

from rehab_app.access import CONSOLE
from rehab_app.bootstrap import open_clinic
from rehab_app.cli.app import app as command
from rehab_app.web import create_app
from rehab_app.web.visit import COOKIE
from sessions.catalogue import TherapySession
from sessions.records import JOINTS
from sessions.records.topics import PATIENT_POSE, PHASE
from sessions.store import SessionReader, header, writer

from .test_from_a_file import write

Make = Callable[..., Any]
LITTLE = [column for column, joint in enumerate(JOINTS) if joint.startswith("little")]


class Desk:
    """A clinic with one patient: files are filed, then asked for by command and by page."""

    def __init__(self, root: Path, clinic: Any) -> None:
        self.root, self.clinic = root, clinic
        self.app = create_app(clinic, open_viewports=lambda _: None)
        clinic.accounts.add_user("therapist", "therapist", "correct horse battery", CONSOLE)
        self.patient = clinic.patients.add(
            CONSOLE, given_name="Rosa", family_name="Braun", birth_date="1949-05-06", side="right"
        ).id

    def file(self, path: Path, patient: str = "") -> str:
        """Enter a file as a session of the patient; its catalogue id."""
        row = TherapySession(
            patient=patient or self.patient,
            sha256=hashlib.sha256(path.read_bytes()).hexdigest(),
            path=str(path.relative_to(self.root)),
            mode="passive",
            started_utc_ns=1_790_000_000_000_000_000,
        )
        return self.clinic.catalogue.add_session(row).id

    def recorded(self, recording: Any, name: str) -> str:
        """Write a recording as a file of the patient and enter it."""
        recording.header = replace(recording.header, subject_id=self.patient, session_id=f"{len(name):032x}")
        return self.file(write(recording, self.root / "sessions" / f"{name}.mcap"))

    def page(self, session: str, name: str = "html") -> httpx.Response:
        """The report as the browser gets it."""

        async def answered() -> httpx.Response:
            transport = httpx.ASGITransport(self.app)
            cookies = httpx.Cookies()
            cookies.set(COOKIE, self.app.state.site.begin("therapist"), domain="localhost.local", path="/")
            async with httpx.AsyncClient(
                transport=transport, base_url="http://localhost", cookies=cookies
            ) as client:
                return await client.get(f"/sessions/{session}/report.{name}")

        return asyncio.run(answered())

    def command(self, named: Any, *more: str) -> Any:
        """What the command line answers; never a traceback."""
        asked = ["report", str(named), "--format", "json", "--data", str(self.root), *more]
        result = CliRunner().invoke(command, asked)
        assert result.exception is None or isinstance(result.exception, SystemExit), result.exception
        assert "Traceback" not in result.output
        return result

    def metrics(self, session: str, folder: Path) -> list[dict[str, Any]]:
        """Numbers of the command's report, which must be there."""
        out = folder / "report.json"
        assert self.command(session, "--out", str(out)).exit_code == 0
        return json.loads(out.read_text())["metrics"]

    def refused(self, session: str) -> tuple[str, httpx.Response]:
        """The command's one sentence and the page's answer, which is one too."""
        result = self.command(session)
        assert result.exit_code == 1
        answer = self.page(session)
        assert 400 <= answer.status_code < 500
        return " ".join(result.stderr.split()), answer


@pytest.fixture(scope="module")
def desk(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Desk]:
    root = tmp_path_factory.mktemp("clinic")
    with open_clinic(root) as clinic:
        (root / "sessions").mkdir(exist_ok=True)
        yield Desk(root, clinic)


def text_of(answer: httpx.Response) -> str:
    assert answer.status_code == 200, answer.text
    assert ">nan<" not in answer.text.lower()
    return re.sub(r"\s+", " ", re.sub(r"<[^>]+>", " ", answer.text))


def test_a_session_without_repetitions(desk: Desk, make_session: Make) -> None:
    session = make_session()
    session.topics[PHASE.name]["phase"][:] = "rest"
    sentence, answer = desk.refused(desk.recorded(session, "at-rest"))
    assert "without a repetition" in sentence
    assert "without a repetition" in answer.text


def test_a_missing_finger(desk: Desk, make_session: Make, tmp_path: Path) -> None:
    session = make_session()
    session.topics[PATIENT_POSE.name]["joint_status"][:, LITTLE] = 0
    named = desk.recorded(session, "no-little-finger")
    for item in desk.metrics(named, tmp_path):
        measured = item["lineage"]["topics"][:1] == [PATIENT_POSE.name]
        if measured and (item["subject"] == "little" or item["subject"].startswith("little_")):
            assert item["value"] is None, item
    assert "Not measurable" in text_of(desk.page(named))


def test_all_frames_estimated(desk: Desk, make_session: Make, tmp_path: Path) -> None:
    session = make_session()
    session.topics[PATIENT_POSE.name]["joint_status"][:] = 1
    named = desk.recorded(session, "all-estimated")
    ranges = [item for item in desk.metrics(named, tmp_path) if item["name"] == "range_of_motion"]
    assert ranges
    assert all("estimated" in item["status"] or item["value"] is None for item in ranges)
    assert "Estimated from other joints, not measured" in text_of(desk.page(named))
    assert "stimato da altre articolazioni" in desk.clinic.reports.html(named, language="it").lower()


@pytest.mark.parametrize("jump_s", [-3600.0, 3600.0])
def test_a_clock_that_jumps(desk: Desk, make_session: Make, jump_s: float, tmp_path: Path) -> None:
    session, plain = make_session(), make_session()
    middle = session.topics[PATIENT_POSE.name]["t_ns"][0] + 5 * 10**9  # where a block of ticks begins
    for rows in session.topics.values():
        if len(rows["t_ns"]):
            rows["t_ns"] = rows["t_ns"] + np.where(rows["t_ns"] >= middle, round(jump_s * 1e9), 0)
    result = desk.command(
        named := desk.recorded(session, f"jump{jump_s:+.0f}"), "--out", str(tmp_path / "a.json")
    )
    if result.exit_code:
        assert "must be" in " ".join(result.stderr.split())
        assert 400 <= desk.page(named).status_code < 500
        return
    known = {
        (item["name"], item["subject"]): item["value"]
        for item in desk.metrics(desk.recorded(plain, f"plain{jump_s:+.0f}"), tmp_path)
    }
    for item in json.loads((tmp_path / "a.json").read_text())["metrics"]:
        straight = known[item["name"], item["subject"]]
        if item["name"] in ("range_of_motion", "dose_time", "robot_work") and item["value"] is not None:
            assert straight is not None
            assert item["value"] <= 1.05 * straight + 1e-2, item
    text_of(desk.page(named))


def test_two_patients_mixed(desk: Desk, make_session: Make) -> None:
    session = make_session()
    session.header = replace(session.header, subject_id="P-9999")
    named = desk.file(write(session, desk.root / "sessions" / "of-another.mcap"))
    sentence, answer = desk.refused(named)
    assert "P-9999" in sentence
    assert desk.patient in sentence
    assert "P-9999" in answer.text
    assert "from end to end" not in answer.text


def test_the_oldest_header(
    desk: Desk, make_session: Make, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    def as_first_released(given: Any) -> dict[str, str]:
        texts = {
            name: text for name, text in header.header_to_texts(given).items() if name not in header._ADDED
        }
        del texts["sha256"]
        canonical = json.dumps(sorted(texts.items()), ensure_ascii=False, separators=(",", ":")).encode()
        return texts | {"sha256": hashlib.sha256(canonical).hexdigest()}

    assert header._ADDED  # otherwise this is the oldest header
    with monkeypatch.context() as patched:
        patched.setattr(writer, "header_to_texts", as_first_released)
        old = desk.recorded(make_session(), "oldest")
    new = desk.recorded(make_session(), "newest")
    with SessionReader(desk.root / "sessions" / "oldest.mcap") as reader:
        assert all(getattr(reader.header, name) == value for name, value in header._ADDED.items())
    one, other = (desk.metrics(named, tmp_path) for named in (old, new))
    assert [item["value"] for item in one] == [item["value"] for item in other]
    assert "Therapy session" in text_of(desk.page(old))


def test_a_foreign_file(desk: Desk, shared_data: Path) -> None:
    foreign = shared_data / "foreign_mcap" / "rosbag2_py__test__resources__mcap__talker__talker.mcap"
    shutil.copyfile(foreign, path := desk.root / "sessions" / "foreign.mcap")
    path.chmod(0o600)
    sentence, answer = desk.refused(desk.file(path))
    assert "must be" in sentence
    assert "from end to end" not in answer.text
    by_path = desk.command(path)
    assert by_path.exit_code == 1
    assert sentence.split(",")[0][:7] == " ".join(by_path.stderr.split())[:7]
