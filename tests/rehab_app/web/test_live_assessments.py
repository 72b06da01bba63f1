"""Tone and target tracking from the browser: started, led through, kept, shown; on simulated devices."""

from __future__ import annotations

import math
import threading
import time

import pytest

from rehab_app.access import CONSOLE
from rehab_app.bootstrap import open_clinic
from rehab_app.services import sweep_postures
from rehab_app.web import create_app

from .conftest import PASSWORD, Browser, NoPictures

PATIENCE_S = 90.0
ARM = "seated, <b>elbow</b> at 90 degrees"
ASKED = {"patient": "P-0001", "present": "P-0001", "speed": "100", "repetitions": "1", "hold": "0"}


@pytest.fixture(scope="module")
def held(tmp_path_factory):
    with open_clinic(tmp_path_factory.mktemp("assessed")) as opened:
        opened.patients.add(CONSOLE, given_name="Ada", family_name="A", birth_date="1950-12-31", side="right")
        for role in ("therapist", "auditor"):
            opened.accounts.add_user(role, role, PASSWORD, CONSOLE)
        take = opened.takes.record_virtual("open_close", "right", 1.5, 3, CONSOLE).take
        opened.takes.approve(take, CONSOLE)
        yield opened, take


@pytest.fixture
def anna(held, monkeypatch):
    monkeypatch.setattr(sweep_postures, "TONE_REPEATS", 1)
    monkeypatch.setattr(sweep_postures, "TONE_SPEEDS_RAD_S", (math.radians(90.0),))
    return Browser(create_app(held[0], open_viewports=lambda _: NoPictures()), "therapist")


def led_through(clinic, visitor):
    """Beat as the page does until the run ends; every state that was shown, by phase."""
    seen, end, pause = {}, time.monotonic() + PATIENCE_S, threading.Event()
    while time.monotonic() < end:
        state = visitor.ask("/live/beat", page="here").json()
        if state["state"] not in ("rehearsing", "playing"):
            clinic.live._thread.join(PATIENCE_S)
            return seen, state
        if state["state"] == "playing":
            seen.setdefault(state["phase"], state)
        pause.wait(0.05)
    raise AssertionError(f"never ended: {state}")


def test_tone_is_led_through_and_kept_and_never_a_grade(held, anna):
    clinic, _ = held
    started = anna.ask("/live/tone", **ASKED, arm=ARM, page="here", twin="mas2")
    assert started.status_code == 200, started.text
    seen, state = led_through(clinic, anna)
    assert state["state"] == "done", state["message"]
    assert "do not help" in seen["Stretch at one speed"]["message"]
    assert seen["Stretch at one speed"]["run"].startswith("Tone at three speeds")
    assert set(seen["Stretch at one speed"]["acts"]) == {"pause", "reverse"}
    assert any("no Modified Ashworth grade" in note for note in state["notes"])
    kept = clinic.protocols.history("P-0001", "tone")[0]
    assert (kept.by, kept.result.session, kept.result.arm_posture) == ("therapist", state["session"], ARM)
    page = anna.get("/patients/P-0001/assessments").text
    assert "&lt;b&gt;elbow" in page
    assert "MAS" not in page


def test_tracking_is_without_help_and_kept(held, anna):
    clinic, take = held
    started = anna.ask("/live/tracking", **ASKED, take=take, mode="passive", page="here", twin="weak")
    assert started.status_code == 200, started.text
    seen, state = led_through(clinic, anna)
    assert state["state"] == "done", state["message"]
    assert "does not help" in seen["Target movement"]["message"]
    browsed = clinic.protocols.history("P-0001", "tracking")[0].result
    assert clinic.catalogue.session(browsed.session).mode == "transparent"
    assert {row.name for row in browsed.tracked} >= {"fingertip_rmse", "timing_delay", "shape_error"}
    assert browsed.session in anna.get("/patients/P-0001/assessments").text


@pytest.mark.parametrize(
    ("verb", "changed", "sentence"),
    [
        ("tone", {"arm": "  "}, "Arm posture is empty"),
        ("tone", {"arm": "x" * 10_000}, "at most 200 characters"),
        ("tone", {"arm": "a\u202eb"}, "U+202E"),
        ("tone", {"arm": ARM, "patient": ""}, "Patient is not chosen"),
        ("tone", {"arm": ARM, "present": ""}, "not confirmed"),
        ("tone", {"arm": ARM, "present": "P-0002"}, "P-0002, who is present"),
        ("tone", {"arm": ARM, "device": "dlr-hit-ii"}, "not worn"),
        ("tracking", {"take": ""}, "Take is not chosen"),
        ("tracking", {"take": "../secret"}, "no catalogue id"),
        ("tracking", {"take": "a" * 10_000}, "no catalogue id"),
        ("tracking", {"repetitions": "0"}, "repetitions"),
        ("tracking", {"patient": ""}, "Patient is not chosen"),
    ],
)
def test_what_cannot_be_assessed_is_a_sentence_and_nothing_moves(held, anna, verb, changed, sentence):
    clinic, take = held
    answer = anna.ask(f"/live/{verb}", **{**ASKED, "take": take, **changed})
    assert answer.status_code == 409
    assert sentence in answer.json()["message"]
    assert clinic.live.snapshot().state not in ("rehearsing", "playing")


def test_a_take_that_nobody_approved_is_not_followed(held, anna):
    clinic, _ = held
    take = clinic.takes.record_virtual("open_close", "right", 1.5, 4, CONSOLE).take
    answer = anna.ask("/live/tracking", **ASKED, take=take)
    assert answer.status_code == 409
    assert "not approved" in answer.json()["message"]


@pytest.mark.parametrize("verb", ["tone", "tracking"])
def test_a_stop_ends_the_test_and_nothing_is_kept_of_it(held, anna, verb):
    clinic, take = held
    before = len(clinic.protocols.history("P-0001"))
    assert anna.ask(f"/live/{verb}", **ASKED, take=take, arm=ARM, page="here").status_code == 200
    while anna.ask("/live/beat", page="here").json()["state"] == "rehearsing":
        threading.Event().wait(0.02)
    assert anna.ask("/stop").status_code == 200
    try:
        assert anna.ask("/live/beat", page="here").json()["state"] == "stopped"
    finally:
        clinic.live._thread.join(PATIENCE_S)
        clinic.live.clear_stop(CONSOLE, confirmed=True)
    assert len(clinic.protocols.history("P-0001")) == before
