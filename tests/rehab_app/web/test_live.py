"""The live page's verbs and heartbeat."""

from __future__ import annotations

import pytest

RECORD = {"exercise": "open_close", "side": "right", "seconds": "2", "countdown": "0"}
PLAY = {"patient": "", "mode": "passive", "speed": "50", "repetitions": "1", "twin": "healthy"}


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("exercise", "juggling"),
        ("side", "both"),
        ("seconds", "0.1"),
        ("seconds", "inf"),
        ("seconds", "x"),
        ("countdown", "-1"),
    ],
)
def test_a_recording_out_of_bounds_is_a_sentence(browser, name, value):
    answer = browser("therapist").ask("/live/record", **{**RECORD, name: value})
    assert answer.status_code == 409
    assert " must be " in answer.json()["message"]


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("take", ""),
        ("take", "../secret"),
        ("take", "no-such"),
        ("take", "zzzz"),
        ("mode", "brutal"),
        ("speed", "5000"),
        ("repetitions", "-1"),
        ("repetitions", "9" * 30),
        ("patient", "P-9999"),
        ("twin", "nobody"),
    ],
)
def test_a_session_out_of_bounds_is_a_sentence(browser, take, clinic, name, value):
    clinic.takes.approve(take, clinic.accounts.account("therapist"))
    answer = browser("therapist").ask("/live/play", **{**PLAY, "take": take, name: value})
    assert answer.status_code == 409
    assert " must be " in answer.json()["message"]
    assert clinic.live.snapshot().state != "rehearsing"


@pytest.mark.parametrize("verb", ["pause", "resume", "speed"])
def test_nothing_to_hold_is_a_sentence(browser, verb):
    answer = browser("therapist").ask(f"/live/{verb}", speed="40")
    assert answer.status_code == 409


def test_only_the_operators_page_beats(browser, clinic, app, monkeypatch):
    beats = []
    monkeypatch.setattr(clinic.live, "operator_beat", lambda: beats.append(1))
    app.state.site.operator.take_over("page-a")
    assert browser("therapist").ask("/live/beat", page="page-b").json()["operator"] is False
    assert browser("auditor").ask("/live/beat", page="page-a").status_code == 200
    assert browser("therapist").ask("/live/beat", page="").status_code == 200
    assert beats == []
    assert browser("therapist").ask("/live/beat", page="page-a").json()["operator"] is True
    assert beats == [1]


def test_a_refused_start_does_not_take_the_operators_place(browser, app):
    app.state.site.operator.take_over("page-a")
    assert browser("therapist").ask("/live/play", page="page-b", **PLAY).status_code == 409
    assert app.state.site.operator.is_("page-a")


def test_pain_is_noted_for_everybody(browser, clinic, monkeypatch):
    noted = []
    monkeypatch.setattr(clinic.live, "pain", lambda account, digit: noted.append((account.name, digit)))
    assert browser("patient").ask("/live/pain", digit="index").status_code == 200
    assert noted == [("patient", "index")]


def test_the_state_names_the_patient_by_two_identifiers(clinic, app, patient):
    from dataclasses import replace

    from rehab_app.web.live_state import live_state

    class Desk:
        def snapshot(self):
            return replace(clinic.live.snapshot(), state="playing", patient_id=patient, frame=7)

    class Shown:
        clinic = type("Clinic", (), {"live": Desk()})()
        patients = app.state.site.patients
        operator = app.state.site.operator

    shown = live_state(Shown(), "")
    assert shown["frame"] == 7
    assert shown["patient"]["born"] == "14 March 1957"
    assert shown["patient"]["side"] == "left"
