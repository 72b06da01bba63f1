"""The session runner through the pages: any page shows the same step, and every verb asks for the role."""

from __future__ import annotations

import pytest


@pytest.fixture
def at_check_in(browser, clinic, patient):
    visitor = browser("therapist")
    assert visitor.ask("/live/session/begin", whom=patient, present=patient).status_code == 200
    yield visitor
    if clinic.runner.course is not None:
        visitor.ask("/live/session/end", note="")


def shown(visitor):
    return visitor.ask("/live/beat", page="").json()["session_course"]


def test_a_second_page_shows_the_same_step_and_whom_it_is_for(browser, at_check_in):
    at_check_in.ask("/live/session/check-in", pain="3", skin="intact", swelling="none")
    for visitor in (at_check_in, browser("assistant"), browser("auditor")):
        seen = shown(visitor)
        assert (seen["step"], seen["number"], seen["checked_in"]) == ("fit", 2, True)
        assert seen["who"]["born"] == "14 March 1957"
    assert [step["state"] for step in seen["steps"]][:3] == ["done", "now", "open"]


def test_nobody_steps_from_a_page_that_is_behind(browser, at_check_in):
    assert at_check_in.ask("/live/session/step", at="check-in", to="fit").status_code == 200
    late = browser("assistant").ask("/live/session/step", at="check-in", to="fit")
    assert late.status_code == 409
    assert "look at the page again" in late.json()["message"]


@pytest.mark.parametrize(
    "fields",
    [
        {"pain": "11"},
        {"pain": "much"},
        {"skin": "purple"},
        {"botulinum": "2999-01-01"},
        {"precautions": "x" * 20_000},
    ],
)
def test_a_check_in_that_is_none_is_a_sentence_and_the_step_stays(at_check_in, fields):
    answer = at_check_in.ask("/live/session/check-in", **fields)
    assert answer.status_code == 409
    assert " must be " in answer.json()["message"]
    assert shown(at_check_in)["step"] == "check-in"


@pytest.mark.parametrize("verb", ["begin", "step", "check-in", "start", "end"])
@pytest.mark.parametrize("role", ["auditor", "patient"])
def test_roles_that_do_not_treat_do_nothing(browser, verb, role):
    assert browser(role).ask(f"/live/session/{verb}").status_code == 403


def test_pain_is_one_tap_for_everybody_and_a_score_may_follow(browser, clinic, at_check_in, patient):
    tapped = browser("patient").ask("/live/pain")
    assert tapped.status_code == 200
    assert tapped.json()["entry"] > 0
    refused = at_check_in.ask("/live/pain", score="12", entry=tapped.json()["entry"])
    assert refused.status_code == 409
    scored = at_check_in.ask("/live/pain", score="5", place="index", entry=tapped.json()["entry"])
    held = [one for one in clinic.journal.entries(patient, ("pain",)) if not one.corrected_by]
    assert [one.id for one in held] == [scored.json()["entry"]]


def test_the_note_is_read_changed_and_kept(clinic, at_check_in, patient):
    at_check_in.ask("/live/session/step", at="check-in", to="note")
    told = at_check_in.get("/live/session/note").json()
    assert "14" not in told["text"]
    assert told["heading"].endswith("LEFT hand")
    answer = at_check_in.ask("/live/session/end", note=told["text"] + "\nAda <b>did</b> well.")
    assert answer.json()["path"] == f"/patients/{patient}"
    assert clinic.journal.entries(patient, ("note",))[0].what.text.endswith("Ada <b>did</b> well.")
    assert shown(at_check_in) is None


def test_another_page_takes_over_only_by_saying_so(browser, app):
    app.state.site.operator.take_over("page-a", "anna")
    seen = browser("assistant").ask("/live/beat", page="page-b").json()
    assert (seen["operator"], seen["operator_words"]) == (False, "anna")
    assert browser("auditor").ask("/live/operate", page="page-b").status_code == 403
    assert browser("assistant").ask("/live/operate", page="page-b").status_code == 200
    seen = browser("assistant").ask("/live/beat", page="page-b").json()
    assert (seen["operator"], seen["operator_words"]) == (True, "This page")
    assert not browser("therapist").ask("/live/beat", page="page-a").json()["operator"]
