"""The live page's verbs and heartbeat."""

from __future__ import annotations

from types import SimpleNamespace

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
        ("device", "ros2:anything"),
        ("space", "everywhere"),
        ("wrist", "200"),
        ("wrist", "straight"),
        ("warm_up", "-2"),
        ("minutes", "5000"),
        ("resistance", "99"),
        ("stiffness", "80"),
        ("hold", "1e9"),
    ],
)
def test_a_session_out_of_bounds_is_a_sentence(browser, take, clinic, name, value):
    clinic.takes.approve(take, clinic.accounts.account("therapist"))
    answer = browser("therapist").ask("/live/play", **{**PLAY, "take": take, name: value})
    assert answer.status_code == 409
    assert " must be " in answer.json()["message"]
    assert clinic.live.snapshot().state != "rehearsing"


@pytest.mark.parametrize("verb", ["pause", "resume", "reverse", "next", "speed"])
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
    assert browser("patient").ask("/live/pain", place="index").status_code == 200
    assert noted == [("patient", "index")]


def test_the_state_names_the_patient_by_two_identifiers(clinic, app, patient):
    from dataclasses import replace

    from rehab_app.web.live_state import live_state

    class Desk:
        def snapshot(self):
            return replace(clinic.live.snapshot(), state="playing", patient_id=patient, frame=7)

    desk = SimpleNamespace(live=Desk(), runner=clinic.runner, interrupted=clinic.interrupted)
    site = app.state.site
    shown = live_state(SimpleNamespace(clinic=desk, patients=site.patients, operator=site.operator), "")
    assert shown["frame"] == 7
    assert shown["patient"]["born"] == "14 March 1957"
    assert shown["patient"]["side"] == "left"


@pytest.mark.parametrize("verb", ["play", "measure", "fit"])
def test_nothing_starts_for_a_patient_whom_nobody_has_compared(browser, take, clinic, patient, verb):
    clinic.takes.approve(take, clinic.accounts.account("therapist"))
    answer = browser("therapist").ask(f"/live/{verb}", **{**PLAY, "take": take, "patient": patient})
    assert answer.status_code == 409
    assert "confirmed by name, birth date and side" in answer.json()["message"]
    other = browser("therapist").ask(
        f"/live/{verb}", **{**PLAY, "take": take, "patient": patient, "present": "P-0999"}
    )
    assert "who is present" in other.json()["message"]
    assert clinic.live.snapshot().state != "rehearsing"


def test_an_assessment_needs_a_patient_and_a_robot_that_is_worn(browser, patient):
    assert "not chosen" in browser("therapist").ask("/live/measure", **PLAY).json()["message"]
    bare = {**PLAY, "patient": patient, "present": patient, "device": "dlr-hit-ii"}
    assert "not worn" in browser("therapist").ask("/live/measure", **bare).json()["message"]


def test_the_form_learns_where_limits_come_from(browser, patient):
    def told(**asked):
        query = "&".join(f"{name}={value}" for name, value in asked.items())
        return browser("therapist").get(f"/live/limits?{query}").json()

    assert told(patient=patient)["words"] == "Shipped defaults: not measured today."
    assert not told(patient=patient, device="dlr-hit-ii")["worn"]
    assert "average hand" in told()["words"]
    assert told(patient=patient, wrist="bent")["kind"] == "caution"
    assert told(patient=patient, wrist="300")["kind"] == "caution"
    assert told(patient="P-9999")["kind"] == "caution"
    assert browser("therapist").get("/live/limits?device=ros2:x").status_code == 404


def acts(**changes):
    from dataclasses import replace

    from rehab_app.services.snapshot import LiveSnapshot
    from rehab_app.web.live_state import acts_of

    return acts_of(replace(LiveSnapshot(), state="playing", kind="therapy", **changes))


def test_only_what_can_be_asked_for_has_a_button():
    from rehab_app.services.snapshot import LiveSnapshot
    from rehab_app.web.live_state import acts_of

    assert acts_of(LiveSnapshot()) == {}
    assert set(acts(phase="move")) == {"pause", "reverse"}
    assert set(acts(phase="cue")) == {"pause", "reverse", "next"}
    assert set(acts(phase="move", paused=True)) == {"resume"}
    assert set(acts(phase="move", reversing=True)) == {"pause", "resume"}
    assert "Skin" in acts(phase="skin-check")["resume"]


def test_every_phase_has_its_words_on_page_and_picture():
    from rehab_app.web.viewport import words as picture
    from rehab_app.web.words import PHASES
    from robot_iface.runtime.live import PHASES as KNOWN

    assert set(KNOWN) - {""} == set(PHASES) == set(picture.PHASES)
