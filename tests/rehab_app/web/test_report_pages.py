"""Reports to take away, progress, comparison, and the proposal that only a therapist answers."""

from __future__ import annotations

import math

import pytest

from rehab_app.access import CONSOLE
from rehab_app.services.plan_items import Plan, PlanItem
from sessions.catalogue import TherapySession
from sessions.reports.past import Kept, Past, Trial, past_to_json, past_version

UTC_NS = 1_700_000_000_000_000_000
DAY_NS = 86_400_000_000_000


@pytest.fixture(scope="module")
def treated(clinic):
    """A patient with two sessions whose numbers are kept, and a plan."""
    patient = clinic.patients.add(
        CONSOLE, given_name="Rosa", family_name="<b>Braun</b>", birth_date="1949-05-06", side="right"
    ).id
    sessions = []
    for number in (1, 2):
        numbers = (
            Kept(
                "range_of_motion", "index_pip", math.radians(30 + 10 * number), 0.5, 0.9, "ok", "1", "encoder"
            ),
        )
        made = Past(
            f"s{number}", f"{number:062x}ab", patient, UTC_NS + number * DAY_NS, "right", "open_close",
            ("assistive",), "stiffness 1.00 Nm/rad", 60.0, "", (), numbers,
            tuple(Trial(index, True, "patient", ()) for index in range(8)),
        )  # fmt: skip
        entered = clinic.catalogue.add_session(
            TherapySession(
                patient=patient,
                sha256=made.sha256,
                path=f"sessions/report-{number}.mcap",
                mode="assistive",
                started_utc_ns=made.utc_start_ns,
            )
        )
        clinic.catalogue.keep_metrics(made.sha256, past_version(), past_to_json(made))
        sessions.append(entered.id)
    item = PlanItem(exercise="open_close", mode="assistive", support="fixed", stiffness_multiple=2.0)
    clinic.plans.change(CONSOLE, Plan(patient=patient, items=(item,)))
    return patient, sessions


@pytest.mark.parametrize(
    ("wanted", "kind", "begins"),
    [
        ("pdf", "application/pdf", b"%PDF"),
        ("csv", "text/csv", b"session_id,"),
        ("json", "application/json", b"{"),
        ("note", "text/plain", b"Recorded movement"),
        ("fhir", "application/fhir+json", b"{"),
    ],
)
def test_a_report_is_taken_away_as_a_file(browser, take, wanted, kind, begins):
    answer = browser("therapist").get(f"/takes/{take}/report.{wanted}")
    assert answer.status_code == 200
    assert answer.headers["content-type"].startswith(kind)
    assert answer.content.startswith(begins)
    assert f"report-{take}" in answer.headers["content-disposition"]


def test_an_unknown_format_or_recording_is_a_sentence(browser, take):
    for path in (f"/takes/{take}/report.docx", "/sessions/nothing/report.pdf"):
        answer = browser("therapist").get(path)
        assert answer.status_code == 404
        assert "must be" in answer.text


def test_a_patient_role_takes_nothing_away(browser, take, treated):
    patient, _ = treated
    for path in (f"/takes/{take}/report.pdf", f"/patients/{patient}/progress", f"/patients/{patient}/next"):
        assert browser("patient").get(path).status_code == 403
        assert browser().get(path).status_code == 303


def test_progress_is_shown_without_a_name_and_runs_no_script(browser, treated):
    patient, _ = treated
    page = browser("therapist").get(f"/patients/{patient}/progress")
    assert "&lt;b&gt;Braun" in page.text
    report = browser("therapist").get(f"/patients/{patient}/progress.html")
    assert "Braun" not in report.text
    assert "a real gain of 10°" not in report.text  # the intervals are wider than the gain
    assert "too small a difference" in report.text
    assert "script-src" not in report.headers["content-security-policy"]
    assert "sandbox" in report.headers["content-security-policy"]


def test_two_sessions_beside_each_other(browser, treated, patient):
    mine, (first, second) = treated
    query = f"?first={first}&second={second}"
    visitor = browser("auditor")
    assert "compare.html" in visitor.get(f"/patients/{mine}/compare{query}").text
    assert "Two of your sessions" in visitor.get(f"/patients/{mine}/compare.html{query}").text
    assert visitor.get(f"/patients/{mine}/compare.pdf{query}").content.startswith(b"%PDF")
    assert visitor.get(f"/patients/{patient}/compare.html{query}").status_code == 404
    same = visitor.get(f"/patients/{mine}/compare?first={first}&second={first}").text
    assert "Choose two different sessions." in same


def test_a_patient_without_sessions_is_told_what_to_do(browser, patient):
    assert "No sessions yet" in browser("therapist").get(f"/patients/{patient}/progress").text
    assert "No plan yet" in browser("therapist").get(f"/patients/{patient}/next").text


def test_the_next_step_is_a_therapists(browser, clinic, treated):
    patient, _ = treated
    page = browser("assistant").get(f"/patients/{patient}/next").text
    assert "16 of the last 16 repetitions succeeded" in page
    assert 'value="accept"' not in page
    digest = clinic.proposals.of_patient(patient)[0].digest
    fields = {"proposal": digest, "answer": "accept"}
    assert browser("assistant").post(f"/patients/{patient}/next", **fields).status_code == 403
    browser("therapist").post(f"/patients/{patient}/next", **(fields | {"proposal": "0" * 64}))
    assert clinic.plans.current(patient).items[0].stiffness_multiple == 2.0
    answer = browser("therapist").post(f"/patients/{patient}/next", **fields)
    assert answer.headers["location"] == f"/patients/{patient}/next"
    assert clinic.plans.current(patient).items[0].stiffness_multiple == pytest.approx(1.6)
    assert "Accepted" in browser("therapist").get(f"/patients/{patient}/next").text


AIMS = [("80", 0.8), ("62,5", 0.625), ("20", 0.7), ("<b>", 0.7), ("nan", 0.7)]


@pytest.mark.parametrize(("percent", "kept"), AIMS)
def test_the_aim_is_set_within_bounds(browser, clinic, treated, percent, kept):
    patient, _ = treated
    clinic.proposals.set_target(CONSOLE, 0.7)
    browser("therapist").post(f"/patients/{patient}/aim", percent=percent)
    assert clinic.proposals.target() == pytest.approx(kept)


def test_a_report_is_in_the_language_of_the_page(browser, take, treated):
    patient, _ = treated
    visitor = browser("therapist")
    visitor.cookies.set("rehab_language", "it", domain="localhost.local", path="/")
    page = visitor.get(f"/takes/{take}/report.html").text
    assert '<html lang="it">' in page
    assert "Movimento registrato" in page
    assert visitor.get(f"/takes/{take}/report.note").text.startswith("Movimento registrato")
    assert "Ha fatto 2 sedute" in visitor.get(f"/patients/{patient}/progress.html").text
    assert '"Movimento' not in visitor.get(f"/takes/{take}/report.json").text
