"""Hazard 23: a recording is altered, or another lies in its place: no hand follows it, no number is made."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from rehab_app.access import CONSOLE
from rehab_app.bootstrap import open_clinic
from rehab_app.errors import Refused
from rehab_app.services.order import Order

ORDER = Order(speed=1.0, repetitions=1)


@pytest.fixture(scope="module")
def treated(tmp_path_factory):
    """A clinic with two approved takes and one session."""
    folder = tmp_path_factory.mktemp("altered") / "clinic"
    with open_clinic(folder) as clinic:
        for seed in (3, 4):
            clinic.takes.record_virtual("open_close", "right", 1.5, seed, CONSOLE)
        first, other = (take.id for take in clinic.takes.list())
        for take in (first, other):
            clinic.takes.approve(take, CONSOLE)
        plan = clinic.therapy.plan(first, ORDER, actor=CONSOLE)
        session = clinic.therapy.rehearse_and_play(plan, actor=CONSOLE).session
    return folder, first, other, session


@pytest.fixture
def clinic(treated, tmp_path):
    folder, first, other, session = treated
    copy = tmp_path / "clinic"
    shutil.copytree(folder, copy)
    with open_clinic(copy) as opened:
        yield opened, first, other, session


def flip_one_bit(path: Path) -> None:
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(content)


def test_an_altered_take_is_not_planned(clinic):
    opened, take, _other, _session = clinic
    flip_one_bit(opened.takes.get(take).path)
    with pytest.raises(Refused):
        opened.therapy.plan(take, ORDER, actor=CONSOLE)


def test_another_whole_take_in_its_place_is_not_planned(clinic):
    opened, take, other, _session = clinic
    shutil.copyfile(opened.takes.get(other).path, opened.takes.get(take).path)
    with pytest.raises(Refused):
        opened.therapy.plan(take, ORDER, actor=CONSOLE)


def test_an_altered_session_gives_no_report(clinic):
    opened, _take, _other, session = clinic
    flip_one_bit(opened.sessions.get(session).path)
    with pytest.raises(Refused):
        opened.reports.json(session)


def test_another_whole_session_in_its_place_gives_no_report(clinic):
    opened, take, _other, session = clinic
    plan = opened.therapy.plan(take, ORDER, actor=CONSOLE)
    second = opened.therapy.rehearse_and_play(plan, actor=CONSOLE).session
    shutil.copyfile(opened.sessions.get(second).path, opened.sessions.get(session).path)
    with pytest.raises(Refused):
        opened.reports.json(session)
