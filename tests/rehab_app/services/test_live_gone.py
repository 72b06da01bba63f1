"""The robot's process dies in mid-session; two people start at once: said, safe, and it can go on."""

from __future__ import annotations

import os
import signal
import threading
import time

import pytest

from rehab_app.access import CONSOLE, Account
from rehab_app.bootstrap import open_clinic
from rehab_app.errors import Refused
from rehab_app.services.order import Order
from robot_iface.link import MotionClient
from sessions.store import partials, verify

ANNA, BERT = Account("anna", "therapist", "1"), Account("bert", "therapist", "2")
PATIENCE_S = 60.0


@pytest.fixture
def clinic(tmp_path, take_file):
    with open_clinic(tmp_path / "clinic") as opened:
        opened.takes.approve(opened.takes.get(take_file).id, CONSOLE)
        yield opened


@pytest.fixture
def take(clinic):
    return clinic.takes.list()[0].id


def until(desk, wanted):
    end = time.monotonic() + PATIENCE_S
    pause = threading.Event()
    while time.monotonic() < end:
        if wanted(desk.snapshot()):
            return desk.snapshot()
        desk.operator_beat()
        pause.wait(0.01)
    raise AssertionError(f"never came: {desk.snapshot()}")


def test_a_robot_that_is_gone_is_said_its_recording_kept_and_the_next_run_starts(clinic, take, monkeypatch):
    processes = []
    start = MotionClient.start

    def starting(client, plan, certificate):
        processes.append(client.pid)
        start(client, plan, certificate)

    monkeypatch.setattr(MotionClient, "start", starting)
    desk = clinic.live
    desk.start_therapy(CONSOLE, None, take, Order(speed=0.5, repetitions=20))
    until(desk, lambda one: one.state == "playing" and one.t_s > 2.0)
    os.kill(processes[0], signal.SIGKILL)
    gone = until(desk, lambda one: one.state == "failed")
    assert "the motion process" in gone.message
    assert "look at the patient" in gone.message
    until(desk, lambda _one: clinic.interrupted.found)
    (restored,) = clinic.interrupted.found
    assert restored.trouble == ""
    verify(clinic.sessions.get(restored.id).path)
    assert not partials(clinic.folder / "sessions")
    until(desk, lambda _one: started(desk, take))
    desk.press_stop("end of test")


def started(desk, take):
    try:
        desk.start_therapy(CONSOLE, None, take, Order(speed=0.5, repetitions=2))
    except Refused:  # the desk is still restoring
        return False
    return True


def test_of_two_clinicians_at_once_one_starts(clinic, take):
    refused = []
    together = threading.Barrier(2)

    def start(who):
        together.wait()
        try:
            clinic.live.start_therapy(who, None, take, Order(speed=0.5, repetitions=2))
        except Refused as refusal:
            refused.append(refusal)

    people = [threading.Thread(target=start, args=(who,)) for who in (ANNA, BERT)]
    for one in people:
        one.start()
    for one in people:
        one.join()
    assert [refusal.thing for refusal in refused] == ["live desk"]
    clinic.live.press_stop("end of test")
