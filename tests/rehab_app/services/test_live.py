"""The live desk in real time: what is asserted are states and their order, never times."""

from __future__ import annotations

import threading
import time

import numpy as np
import pytest

from rehab_app.access import CONSOLE, Account
from rehab_app.bootstrap import open_clinic
from rehab_app.errors import REFUSALS, Refused
from robot_iface.link import MotionClient
from sessions.records.topics import EVENTS
from sessions.store import SessionReader, verify

AUDITOR = Account("otto", "auditor", "3")
ASSISTANT = Account("bert", "assistant", "2")
PATIENCE_S = 60.0


@pytest.fixture
def clinic(tmp_path, take_file):
    with open_clinic(tmp_path / "clinic") as opened:
        opened.takes.approve(opened.takes.get(take_file).id, CONSOLE)
        yield opened


@pytest.fixture
def take(clinic):
    return clinic.takes.list()[0].id


def until(desk, wanted, beat=True):
    """Wait for a snapshot that is wanted; the operator's page beats meanwhile unless it is told not to."""
    end = time.monotonic() + PATIENCE_S
    pause = threading.Event()
    while time.monotonic() < end:
        snapshot = desk.snapshot()
        if wanted(snapshot):
            return snapshot
        assert snapshot.state != "failed", snapshot.message
        if beat:
            desk.operator_beat()
        pause.wait(0.01)
    raise AssertionError(f"never came: {desk.snapshot()}")


def moving(snapshot):
    return (
        snapshot.state == "playing" and snapshot.phase == "move" and snapshot.patient_joints_rad is not None
    )


def test_a_session_is_rehearsed_played_and_recorded(clinic, take):
    desk = clinic.live
    desk.start_therapy(CONSOLE, None, take, speed=1.0, repetitions=1)
    assert desk.snapshot().state == "rehearsing"
    first = until(desk, moving)
    later = until(desk, lambda one: one.frame > first.frame + 10)
    assert not np.array_equal(first.patient_joints_rad, later.patient_joints_rad)
    assert later.fingertip_error_m.shape == (5,)
    assert later.support == pytest.approx(3.0)
    assert later.safety_state == "ACTIVE"
    t_s, error_mm = desk.error_history()
    assert t_s.size == error_mm.size > 5
    done = until(desk, lambda one: one.state == "done")
    row = clinic.sessions.get(done.session_id)
    verify(row.path)
    assert clinic.sessions.list() == (row,)


def test_stop_needs_no_role_latches_and_the_session_is_sealed(clinic, take):
    desk = clinic.live
    desk.start_therapy(CONSOLE, None, take, speed=0.5, repetitions=20)
    until(desk, moving)
    desk.press_stop("key")
    stopped = desk.snapshot()
    assert (stopped.state, stopped.stop_source) == ("stopped", "key")
    until(desk, lambda _one: clinic.sessions.list())
    (row,) = clinic.sessions.list()
    verify(row.path)
    with SessionReader(row.path) as reader:
        events = list(reader.records(EVENTS))
    assert [event.cause for event in events if event.kind == "stop"] == ["e-stop"]
    frame = desk.snapshot().frame
    assert desk.snapshot().frame == frame
    with pytest.raises(Refused, match="clear the stop"):
        desk.start_therapy(CONSOLE, None, take)
    with pytest.raises(Refused, match="clear the stop"):
        desk.start_recording(CONSOLE, "open_close", "right", 5.0)
    with pytest.raises(Refused, match="looked at the patient"):
        desk.clear_stop(CONSOLE, confirmed=False)
    with pytest.raises(Refused, match="may not clear stop"):
        desk.clear_stop(ASSISTANT, confirmed=True)
    until(desk, lambda _one: cleared(desk))
    assert desk.snapshot().state == "idle"
    clinic.audit.close()
    verbs = [row.verb for row in clinic.catalogue.audit()]
    assert {"stop", "clear stop", "play", "session"} <= set(verbs)


def cleared(desk):
    try:
        desk.clear_stop(CONSOLE, confirmed=True)
    except Refused as refusal:
        return refusal.value != "still braking and sealing"
    return True


def test_a_stop_while_rehearsing_lets_nothing_move(clinic, take):
    desk = clinic.live
    desk.start_therapy(CONSOLE, None, take, speed=0.5, repetitions=2)
    desk.press_stop("key")
    until(desk, lambda _one: cleared(desk))
    assert clinic.sessions.list() == ()


def test_a_silent_operator_page_holds_and_resume_goes_on(clinic, take):
    desk = clinic.live
    desk.start_therapy(CONSOLE, None, take, speed=1.0, repetitions=2)
    until(desk, moving)
    held = until(desk, lambda one: one.safety_state == "HOLD", beat=False)
    assert held.state == "playing"
    held = until(desk, lambda one: one.paused, beat=False)
    assert "fell silent" in held.message
    desk.resume(CONSOLE)
    until(desk, lambda one: one.safety_state == "ACTIVE" and not one.paused)
    desk.press_stop("end of test")


def test_pause_resume_and_speed(clinic, take):
    desk = clinic.live
    desk.start_therapy(CONSOLE, None, take, speed=0.8, repetitions=3)
    until(desk, moving)
    desk.pause(CONSOLE)
    assert desk.snapshot().paused
    still = until(desk, lambda one: one.paused)
    desk.resume(CONSOLE)
    until(desk, lambda one: one.frame > still.frame + 5 and not one.paused)
    desk.set_speed(CONSOLE, 0.4)
    assert desk.snapshot().speed == 0.4
    with pytest.raises(REFUSALS, match=r"0\.1 to 1"):
        desk.set_speed(CONSOLE, 2.0)
    with pytest.raises(Refused, match="may not play"):
        desk.pause(AUDITOR)
    with pytest.raises(Refused, match="live desk"):
        desk.start_therapy(CONSOLE, None, take)
    desk.pain(None)
    until(desk, lambda one: one.safety_state == "HOLD")
    desk.press_stop("end of test")


def test_nothing_played_cannot_be_paused(clinic):
    for verb in (clinic.live.pause, clinic.live.resume):
        with pytest.raises(Refused, match="nothing is played"):
            verb(CONSOLE)


def test_an_unapproved_take_is_refused_at_once_or_fails_with_a_sentence(tmp_path, take_file):
    with open_clinic(tmp_path / "unapproved") as clinic:
        take = clinic.takes.get(take_file).id
        with pytest.raises(Refused, match="not approved"):
            clinic.live.start_therapy(CONSOLE, None, take)
        assert clinic.live.snapshot().state == "idle"


def test_a_take_is_recorded_in_real_time_and_can_be_finished_early(clinic):
    desk = clinic.live
    desk.start_recording(CONSOLE, "open_close", "right", 30.0, countdown_s=0.2, seed=3)
    assert desk.snapshot().state == "countdown"
    until(desk, lambda one: one.state == "recording" and one.t_s > 2.5)
    assert desk.camera_jpeg().startswith(b"\xff\xd8")
    snapshot = desk.snapshot()
    assert snapshot.therapist_joints_rad is not None
    assert 0.0 < snapshot.tracking_quality <= 1.0
    desk.finish_recording(CONSOLE)
    done = until(desk, lambda one: one.state == "done")
    row = clinic.takes.get(done.take_id)
    assert row.approved_by is None
    assert row.duration_s < 20.0


def test_a_recording_can_be_called_off_in_its_countdown(clinic):
    before = clinic.takes.list()
    clinic.live.start_recording(CONSOLE, "open_close", "right", 5.0, countdown_s=30.0)
    clinic.live.finish_recording(CONSOLE)
    until(clinic.live, lambda one: one.state == "idle")
    assert clinic.takes.list() == before
    with pytest.raises(Refused, match="may not record"):
        clinic.live.start_recording(AUDITOR, "open_close", "right", 5.0)


def test_a_stop_of_the_supervisor_latches_like_a_pressed_one_and_names_its_cause(clinic, take, monkeypatch):
    desk = clinic.live
    beat = MotionClient.beat
    silent = threading.Event()
    monkeypatch.setattr(MotionClient, "beat", lambda client: None if silent.is_set() else beat(client))
    desk.start_therapy(CONSOLE, None, take, speed=0.5, repetitions=20)
    until(desk, moving)
    silent.set()  # the app is as good as dead
    stopped = until(desk, lambda one: "heartbeat" in one.stop_source)
    assert stopped.stop_source == "the safety supervisor: heartbeat lost"
    assert "heartbeat lost" in stopped.message
    until(desk, lambda _one: clinic.sessions.list())
    with pytest.raises(Refused, match="cleared"):
        desk.start_therapy(CONSOLE, None, take)
