"""What pages show: escaped, complete, with sentences instead of failures."""

from __future__ import annotations

import pytest

from .conftest import ATTACK

ESCAPED = "&lt;img src=x onerror=alert(1)&gt;"
FORM = {
    "given_name": "Eva",
    "family_name": "Lind",
    "birth_date": "1960-02-29",
    "side": "right",
    "hand_length_cm": "17,5",
}


@pytest.mark.parametrize("path", ["/patients", "/patients/{patient}", "/live"])
def test_names_are_escaped(browser, patient, path):
    text = browser("therapist").get(path.format(patient=patient)).text
    assert ATTACK not in text
    assert ESCAPED in text
    assert "O&#39;Hara &amp; Sons" in text


def test_a_patient_is_named_by_name_birth_date_and_side(browser, patient):
    text = browser("therapist").get(f"/patients/{patient}").text
    assert "14 March 1957" in text
    assert "Left hand" in text


def test_a_new_patient_is_added_and_shown(browser, clinic):
    visitor = browser("therapist")
    answer = visitor.post("/patients", **FORM)
    added = clinic.patients.get(answer.headers["location"].rsplit("/", 1)[1])
    assert (added.given_name, added.side, added.hand_length_m) == ("Eva", "right", pytest.approx(0.175))
    assert "Eva Lind was added." in visitor.get(answer.headers["location"]).text


@pytest.mark.parametrize(
    ("name", "value", "sentence"),
    [
        ("birth_date", "29.2.1961", "Birth date is"),
        ("birth_date", "", "Birth date is empty"),
        ("given_name", " ", "Given name is empty"),
        ("side", "", "Side is"),
        ("hand_length_cm", "400", "Hand length is"),
        ("hand_length_cm", "nan", "Hand length is"),
        ("hand_length_cm", "<b>", "Hand length is"),
    ],
)
def test_a_wrong_form_comes_back_with_its_sentence(browser, clinic, name, value, sentence):
    before = len(clinic.patients.list())
    answer = browser("therapist").post("/patients", **{**FORM, name: value})
    assert answer.status_code == 409
    assert sentence in answer.text
    assert "Lind" in answer.text
    assert "<b>" not in answer.text
    assert len(clinic.patients.list()) == before


@pytest.mark.parametrize("kind", ["takes", "sessions"])
@pytest.mark.parametrize("named", ["zzzz", "..", "%2e%2e%2fsecret", "a.mcap", "~", "%00"])
@pytest.mark.parametrize("tail", ["", "/report", "/report.html", "/report.json"])
def test_what_is_no_id_is_refused_and_never_a_path(browser, kind, named, tail):
    answer = browser("therapist").get(f"/{kind}/{named}{tail}")
    assert answer.status_code in (404, 307, 303)
    assert "Traceback" not in answer.text


def test_a_take_is_shown_then_approved(browser, clinic, unseen_take):
    take = unseen_take
    visitor = browser("therapist")
    assert "Not approved" in visitor.get(f"/takes/{take}").text
    answer = visitor.post(f"/takes/{take}/approve")
    assert answer.headers["location"] == f"/takes/{take}"
    assert clinic.takes.approval(take).by == "therapist"
    assert "Approved by therapist" in visitor.get(f"/takes/{take}").text
    answer = visitor.get(f"/live/takes?take={take}", accept="application/json").json()
    assert answer["take"] == {"id": take, "approved_by": "therapist"}
    assert take in [row["id"] for row in answer["rows"]]


def test_a_report_runs_no_script_and_may_be_framed_by_the_shell(browser, take):
    visitor = browser("auditor")
    answer = visitor.get(f"/takes/{take}/report.html")
    assert answer.status_code == 200
    policy = answer.headers["content-security-policy"]
    assert "script-src" not in policy
    assert "default-src 'none'" in policy
    assert "sandbox" in policy
    assert "allow-scripts" not in policy
    assert answer.headers["x-frame-options"] == "SAMEORIGIN"
    assert f"/takes/{take}/report.html" in visitor.get(f"/takes/{take}/report").text
    assert visitor.get(f"/takes/{take}/report.json").json()["metrics"]


def test_an_unknown_page_and_a_start_page(browser):
    for visitor in (browser("therapist"), browser()):
        answer = visitor.get("/nowhere")
        assert answer.status_code == 404
        assert "EMERGENCY STOP" in answer.text
    assert browser("therapist").get("/").headers["location"] == "/live"
    assert browser().get("/").headers["location"] == "/sign-in"
