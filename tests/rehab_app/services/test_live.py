"""The live desk in real time: what is asserted are states and their order, never times."""

from __future__ import annotations

import threading
import time
from types import SimpleNamespace

import numpy as np
import pytest

from rehab_app.access import CONSOLE, Account
from rehab_app.bootstrap import open_clinic
from rehab_app.errors import REFUSALS, Refused
from rehab_app.services.order import Order
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
    desk.start_therapy(CONSOLE, None, take, Order(speed=1.0, repetitions=1))
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
    desk.start_therapy(CONSOLE, None, take, Order(speed=0.5, repetitions=20))
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
    desk.start_therapy(CONSOLE, None, take, Order(speed=0.5, repetitions=2))
    desk.press_stop("key")
    until(desk, lambda _one: cleared(desk))
    assert clinic.sessions.list() == ()


def test_a_silent_operator_page_holds_and_resume_goes_on(clinic, take):
    desk = clinic.live
    desk.start_therapy(CONSOLE, None, take, Order(speed=1.0, repetitions=2))
    until(desk, moving)
    held = until(desk, lambda one: one.safety_state == "HOLD", beat=False)
    assert held.state == "playing"
    held = until(desk, lambda one: one.paused, beat=False)
    assert "fell silent" in held.message
    desk.controls.resume(CONSOLE)
    until(desk, lambda one: one.safety_state == "ACTIVE" and not one.paused)
    desk.press_stop("end of test")


def test_pause_resume_and_speed(clinic, take):
    desk = clinic.live
    desk.start_therapy(CONSOLE, None, take, Order(speed=0.8, repetitions=3))
    until(desk, moving)
    desk.controls.pause(CONSOLE)
    assert desk.snapshot().paused
    still = until(desk, lambda one: one.paused)
    desk.controls.resume(CONSOLE)
    until(desk, lambda one: one.frame > still.frame + 5 and not one.paused)
    desk.controls.set_speed(CONSOLE, 0.4)
    assert desk.snapshot().speed == 0.4
    with pytest.raises(REFUSALS, match=r"0\.1 to 1"):
        desk.controls.set_speed(CONSOLE, 2.0)
    desk.controls.set_speed(AUDITOR, 0.3)  # slower is anybody's
    for stronger in (desk.controls.resume, lambda one: desk.controls.set_speed(one, 0.5)):
        with pytest.raises(Refused, match="may not play"):
            stronger(AUDITOR)
    with pytest.raises(Refused, match="live desk"):
        desk.start_therapy(CONSOLE, None, take)
    desk.pain(None)
    until(desk, lambda one: one.safety_state == "HOLD")
    desk.press_stop("end of test")


def test_nothing_played_cannot_be_paused(clinic):
    for verb in (clinic.live.controls.pause, clinic.live.controls.advance, clinic.live.controls.reverse):
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
    snapshot = until(
        desk, lambda one: one.state == "recording" and one.t_s > 2.5 and one.therapist_joints_rad is not None
    )
    assert desk.camera_jpeg().startswith(b"\xff\xd8")
    assert 0.0 <= snapshot.tracking_quality <= 1.0
    until(desk, lambda one: one.tracking_quality > 0.0)
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
    desk.start_therapy(CONSOLE, None, take, Order(speed=0.5, repetitions=20))
    until(desk, moving)
    silent.set()  # the app is as good as dead
    stopped = until(desk, lambda one: "heartbeat" in one.stop_source)
    assert stopped.stop_source == "the safety supervisor: heartbeat lost"
    assert "heartbeat lost" in stopped.message
    until(desk, lambda _one: clinic.sessions.list())
    with pytest.raises(Refused, match="cleared"):
        desk.start_therapy(CONSOLE, None, take)


def test_the_movement_goes_back_waits_and_goes_on_again(clinic, take):
    desk = clinic.live
    desk.start_therapy(CONSOLE, None, take, Order(speed=0.4, repetitions=20))
    until(desk, moving)
    with pytest.raises(Refused, match="may not play"):
        desk.controls.reverse(AUDITOR)
    desk.controls.reverse(CONSOLE)
    back = desk.snapshot()
    assert back.reversing
    assert not back.paused
    desk.controls.resume(CONSOLE)
    until(desk, lambda one: not one.reversing and one.frame > back.frame + 5)
    desk.pain(None)
    until(desk, lambda one: one.safety_state == "HOLD")
    with pytest.raises(Refused, match="not held"):
        desk.controls.reverse(CONSOLE)
    assert "Pain was entered." in until(desk, lambda one: "Pain was entered." in one.notes).notes
    desk.press_stop("end of test")
    until(desk, lambda _one: clinic.sessions.list())
    clinic.audit.close()
    verbs = [row.verb for row in clinic.catalogue.audit()]
    assert {"start", "reverse", "resume", "stop"} <= set(verbs)


def test_a_sweep_has_no_therapist_and_needs_a_patient_who_is_there(clinic):
    desk = clinic.live
    patient, other = (
        clinic.patients.add(
            CONSOLE, given_name="Ada", family_name="L", birth_date="1950-12-31", side="left"
        ).id
        for _ in range(2)
    )
    with pytest.raises(Refused, match="not chosen"):
        desk.start_assessment(CONSOLE, "range", None)
    with pytest.raises(Refused, match="who is present"):
        desk.start_assessment(CONSOLE, "range", patient, present=other)
    with pytest.raises(Refused, match="not worn"):
        desk.start_assessment(CONSOLE, "fit", patient, Order(device="dlr-hit-ii"))
    with pytest.raises(Refused, match="may not play"):
        desk.start_assessment(AUDITOR, "range", patient)
    desk.start_assessment(CONSOLE, "range", patient, present=patient)
    assert desk.snapshot().notes == ("No limits were measured today: the shipped defaults hold.",)
    shown = until(desk, lambda one: one.phase == "open" and one.patient_joints_rad is not None)
    assert (shown.kind, shown.repetitions, shown.started_by) == ("range", 4, "patient")
    assert shown.therapist_joints_rad is None
    assert shown.fingertip_error_m is None
    desk.controls.advance(CONSOLE)
    until(desk, lambda one: one.started_by == "robot")
    desk.controls.reverse(CONSOLE)
    until(desk, lambda one: one.phase == "rest")
    assert not desk.snapshot().reversing
    desk.press_stop("end of test")


def test_a_robot_that_nobody_wears_is_drawn_by_its_own_joints(clinic, take):
    desk = clinic.live
    desk.start_therapy(CONSOLE, None, take, Order(device="dlr-hit-ii", speed=0.5, repetitions=2))
    shown = until(desk, moving)
    assert not shown.worn
    assert shown.patient_joints_rad.shape == (21,)
    desk.press_stop("end of test")


def test_who_clears_at_once_waits_for_the_seal_and_a_second_stop_stays(clinic, take, monkeypatch):
    desk = clinic.live
    desk.start_therapy(CONSOLE, None, take, Order(speed=1.0, repetitions=5))
    until(desk, moving)
    desk.press_stop("key")
    desk.clear_stop(CONSOLE, confirmed=True)
    assert desk.snapshot().state == "idle"
    assert len(clinic.sessions.list()) == 1
    desk.press_stop("key")
    slow = SimpleNamespace(join=lambda _s: desk.press_stop("button"), is_alive=lambda: False)
    monkeypatch.setattr(desk, "_thread", slow)
    with pytest.raises(Refused, match="pressed anew"):
        desk.clear_stop(CONSOLE, confirmed=True)
    assert desk.snapshot().stop_source == "button"
