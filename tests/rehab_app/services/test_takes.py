from __future__ import annotations

import numpy as np
import pytest

from rehab_app.access import CONSOLE, Account
from rehab_app.bootstrap import open_clinic
from rehab_app.errors import Refused
from sessions.records import FINGERS, JOINTS
from sessions.store import verify

AUDITOR = Account("otto", "auditor", "3")
ASSISTANT = Account("bert", "assistant", "2")


@pytest.fixture
def clinic(tmp_path):
    with open_clinic(tmp_path / "clinic") as opened:
        yield opened


def test_an_import_lies_in_the_clinic_and_a_copy_where_it_was_asked_for(clinic, recording, tmp_path):
    summary = clinic.takes.import_file(recording, side="right", actor=CONSOLE, out=tmp_path / "mine.mcap")
    assert summary.path == tmp_path / "mine.mcap"
    assert (summary.frames, summary.landmarks, summary.gaps) == (90, 21, 0)
    (row,) = clinic.takes.list()
    assert row.id == summary.take
    assert row.path.is_relative_to(clinic.folder / "takes")
    assert row.path.read_bytes() == summary.path.read_bytes()
    assert verify(summary.path).digest_noted
    assert clinic.takes.get(summary.path) == row


def test_an_existing_out_is_refused_before_any_work(clinic, recording, tmp_path):
    there = tmp_path / "mine.mcap"
    there.write_text("precious")
    with pytest.raises(Refused, match="there already"):
        clinic.takes.import_file(recording, side="right", actor=CONSOLE, out=there)
    assert there.read_text() == "precious"
    assert clinic.takes.list() == ()
    assert list((clinic.folder / "takes").iterdir()) == []


@pytest.mark.parametrize("out", ["mine.txt", "nowhere/mine.mcap"])
def test_an_impossible_out_is_refused(clinic, recording, tmp_path, out):
    with pytest.raises(Refused, match="--out"):
        clinic.takes.import_file(recording, side="right", actor=CONSOLE, out=tmp_path / out)
    assert clinic.takes.list() == ()


def test_a_take_named_by_path_is_copied_in_and_survives_its_original(clinic, take_file, tmp_path):
    path = tmp_path / "theirs.mcap"
    path.write_bytes(take_file.read_bytes())
    row = clinic.takes.get(path)
    path.unlink()
    clinic.takes.approve(row.id, CONSOLE)
    assert clinic.takes.approval(row.id).by == "console"
    assert clinic.takes.get(row.id).approved_by == "console"


def test_approval_is_of_exactly_these_bytes(clinic, take_file):
    row = clinic.takes.get(take_file)
    take = row.id
    content = bytearray(row.path.read_bytes())
    content[-1] ^= 1
    row.path.write_bytes(content)
    with pytest.raises(Refused, match="changed"):
        clinic.takes.approve(take, CONSOLE)
    assert clinic.takes.approval(take) is None


def test_roles_hold(clinic, recording, take_file):
    with pytest.raises(Refused, match="may not record"):
        clinic.takes.import_file(recording, side="right", actor=AUDITOR)
    take = clinic.takes.get(take_file).id
    with pytest.raises(Refused, match="may not approve"):
        clinic.takes.approve(take, ASSISTANT)


def test_the_motion_is_the_recorded_one(stocked):
    (row,) = stocked.takes.list()
    motion = stocked.takes.motion(row.id)
    assert motion.side == "right"
    low, high = np.percentile(motion.joints_rad, (1, 99), axis=0)
    ranges = np.rad2deg(high - low)
    bent = [JOINTS.index(f"{finger}_{joint}") for finger in FINGERS for joint in ("mcp_flexion", "pip")]
    assert ranges[bent] == pytest.approx(np.full(8, 35.0), abs=4.0)


@pytest.mark.parametrize(
    ("exercise", "side", "seconds"),
    [("juggling", "right", 5.0), ("open_close", "both", 5.0), ("open_close", "right", 0.5)],
)
def test_what_cannot_be_recorded_is_refused(clinic, exercise, side, seconds):
    with pytest.raises(Refused):
        clinic.takes.record_virtual(exercise, side, seconds, 1, CONSOLE)
    assert list((clinic.folder / "takes").iterdir()) == []


def test_a_take_replays_without_a_reference(stocked):
    (row,) = stocked.takes.list()
    replay = stocked.sessions.replay(row.id)
    assert replay.reference_joints_rad is None
    assert replay.patient_joints_rad.shape == (replay.t_s.size, 21)
    assert replay.t_s[0] == 0.0
    assert replay.t_s[-1] == pytest.approx(row.duration_s)


def test_a_take_reports_in_both_formats(stocked, tmp_path):
    (row,) = stocked.takes.list()
    made = stocked.reports.report([row.id], ("html", "json"), tmp_path / "reports", actor=CONSOLE)
    assert [path.suffix for path in made] == [".html", ".json"]
    assert made[0].read_text(encoding="utf-8") == stocked.reports.html(row.id)
    assert made[1].read_bytes() == stocked.reports.json(row.id)
    with pytest.raises(Refused, match="one of html, pdf, csv"):
        stocked.reports.report([row.id], ("docx",), tmp_path, actor=CONSOLE)
    with pytest.raises(Refused, match="unknown"):
        stocked.reports.html("deadbeef")
