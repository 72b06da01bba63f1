"""A server that was killed in mid-session: the next one restores what was recorded, enters it and says so."""

from __future__ import annotations

import os
import shutil
import time

import pytest

from rehab_app.access import CONSOLE
from rehab_app.bootstrap import open_clinic
from rehab_app.services.order import Order
from sessions.store import SessionReader, recover, verify


@pytest.fixture(scope="module")
def killed(tmp_path_factory, take_file):
    """A clinic whose session file was left without its end, as a killed server leaves it."""
    folder = tmp_path_factory.mktemp("killed") / "clinic"
    with open_clinic(folder) as clinic:
        take = clinic.takes.get(take_file)
        clinic.takes.approve(take.id, CONSOLE)
        patient = clinic.patients.add(
            CONSOLE, given_name="Clara", family_name="Weber", birth_date="1957-03-14", side="right"
        )
        plan = clinic.therapy.plan(
            take.id, Order(speed=1.0, repetitions=1), actor=CONSOLE, patient_id=patient.id
        )
        played = clinic.therapy.rehearse_and_play(plan, actor=CONSOLE)
        left = clinic.sessions.get(played.session).path.read_bytes()
    return folder, patient.id, take.id, left


@pytest.fixture
def clinic(killed, tmp_path):
    folder, patient, take, left = killed
    copy = tmp_path / "clinic"
    shutil.copytree(folder, copy)
    partial = copy / "sessions" / "20260101T000000Z-0badcafe.partial.mcap"
    partial.write_bytes(left[: len(left) * 3 // 4])
    with open_clinic(copy) as opened:
        yield opened, patient, take, partial


def test_a_cut_session_is_restored_entered_and_said(clinic):
    opened, patient, take, partial = clinic
    (restored,) = opened.interrupted.restore()
    assert (restored.kind, restored.trouble) == ("sessions", "")
    row = opened.sessions.get(restored.id)
    assert (row.patient_id, row.take_id, row.mode) == (patient, take, "passive")
    verify(row.path)
    with SessionReader(row.path) as reader:
        assert reader.header.subject_id == patient
    assert not partial.exists()
    assert opened.interrupted.restore() == (restored,)  # nothing is restored twice


def test_what_cannot_be_restored_stays_and_is_said(clinic):
    opened, _, _, partial = clinic
    partial.write_bytes(b"not a recording")
    (restored,) = opened.interrupted.restore()
    assert "could not be restored" in restored.trouble
    assert partial.exists()


def test_a_session_killed_in_the_last_step_of_sealing_gets_its_name_and_is_entered(clinic, killed):
    opened, patient, _, partial = clinic
    partial.write_bytes(killed[3])
    (restored,) = opened.interrupted.restore()
    assert (restored.kind, restored.trouble) == ("sessions", "")
    row = opened.sessions.get(restored.id)
    assert row.patient_id == patient
    assert row.path.read_bytes() == killed[3]
    assert not partial.exists()


def test_a_session_that_was_recovered_but_not_removed_is_entered_once(clinic):
    opened, _, _, partial = clinic
    before = len(opened.sessions.list())
    recover(partial)  # and the server was killed here
    (restored,) = opened.interrupted.restore()
    assert restored.trouble == ""
    assert len(opened.sessions.list()) == before + 1
    assert not partial.exists()


def test_what_was_sealed_but_never_entered_is_entered_once_it_is_at_rest(clinic, killed):
    opened, patient, _, partial = clinic
    partial.unlink()
    stray = partial.with_name("20260101T000000Z-0badcafe.mcap")
    stray.write_bytes(killed[3])
    assert opened.interrupted.restore() == ()  # whoever sealed it may be entering it now
    an_hour_ago(stray)
    (restored,) = opened.interrupted.restore()
    assert opened.sessions.get(restored.id).patient_id == patient
    assert opened.interrupted.restore() == (restored,)
    assert stray.exists()


def test_a_damaged_stray_is_told_once_and_stays(clinic):
    opened, _, _, partial = clinic
    stray = partial.rename(partial.with_name("20260101T000000Z-0badcafe.mcap"))
    an_hour_ago(stray)
    (told,) = opened.interrupted.restore()
    assert "could not be restored" in told.trouble
    assert opened.interrupted.restore() == (told,)
    assert stray.exists()


def test_forgotten_working_files_are_removed_and_fresh_ones_are_not(clinic):
    opened, _, _, partial = clinic
    partial.unlink()
    forgotten = partial.with_name("a.recovering.partial.mcap"), opened.folder / ".ledger.part"
    fresh = opened.folder / ".other.part"
    aside = opened.folder / ".backup-abc"
    aside.mkdir()
    (aside / "copy").write_bytes(b"x")
    for path in (*forgotten, fresh):
        path.write_bytes(b"x")
    for path in (*forgotten, aside):
        an_hour_ago(path)
    opened.interrupted.restore()
    assert not any(path.exists() for path in (*forgotten, aside))
    assert fresh.exists()


def an_hour_ago(path):
    """Make a file look as if nobody had touched it since."""
    then_s = time.time() - 4000.0
    os.utime(path, (then_s, then_s))
