"""A server that was killed in mid-session: the next one restores what was recorded, enters it and says so."""

from __future__ import annotations

import shutil

import pytest

from rehab_app.access import CONSOLE
from rehab_app.bootstrap import open_clinic
from rehab_app.services.order import Order
from sessions.store import SessionReader, verify


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
