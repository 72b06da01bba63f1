"""The session runner: one session, one step, kept through a restart; a note that says what was done."""

from __future__ import annotations

import threading

import pytest

from rehab_app.access import CONSOLE, Account
from rehab_app.bootstrap import open_clinic
from rehab_app.errors import Refused
from rehab_app.services.journal import CheckIn, Note, PainReport
from rehab_app.services.plan_items import Plan, PlanItem
from rehab_app.services.runner_steps import KEYS, STEPS

AUDITOR = Account("otto", "auditor", "3")
PATIENT = Account("clara", "patient", "4")
THERAPIST = Account("anna", "therapist", "1")


@pytest.fixture
def clinic(tmp_path, take_file):
    with open_clinic(tmp_path / "clinic") as opened:
        opened.takes.approve(opened.takes.get(take_file).id, CONSOLE)
        opened.patients.add(
            CONSOLE, given_name="Clara", family_name="Weber", birth_date="1957-03-14", side="right"
        )
        yield opened


@pytest.fixture
def patient(clinic):
    return clinic.patients.list()[0].id


@pytest.fixture
def begun(clinic, patient):
    clinic.runner.begin(THERAPIST, patient, patient)
    return clinic.runner


def test_a_session_begins_only_for_somebody_whom_a_person_confirmed(clinic, patient):
    with pytest.raises(Refused, match="confirmed by name, birth date and side"):
        clinic.runner.begin(THERAPIST, patient, "")
    with pytest.raises(Refused, match="may not play"):
        clinic.runner.begin(AUDITOR, patient, patient)
    assert clinic.runner.course is None
    clinic.runner.begin(THERAPIST, patient, patient)
    with pytest.raises(Refused, match="going on with"):
        clinic.runner.begin(THERAPIST, patient, patient)


def test_the_steps_go_on_back_and_anywhere_and_say_what_was_skipped(begun):
    begun.check_in(THERAPIST, CheckIn(pain=2, skin="intact", swelling="none"))
    assert begun.course.step.key == "fit"
    begun.go(THERAPIST, "fit", "limits", "  device still on ")
    begun.go(THERAPIST, "limits", "fit")
    assert begun.course.state_of("limits") == "skipped"
    begun.go(THERAPIST, "fit", "task")
    states = [begun.course.state_of(key) for key in KEYS]
    assert states == [
        "done", "skipped", "skipped", "skipped", "skipped", "skipped", "now", "open", "open"
    ]  # fmt: skip
    assert begun.course.stays[1].reason == "device still on"
    with pytest.raises(Refused, match="one of check-in"):
        begun.go(THERAPIST, "task", "lunch")


def test_of_two_pages_that_step_at_once_one_steps(begun):
    refused = []

    def step():
        try:
            begun.go(THERAPIST, "check-in", "fit")
        except Refused as refusal:
            refused.append(refusal)

    pages = [threading.Thread(target=step) for _ in range(6)]
    for page in pages:
        page.start()
    for page in pages:
        page.join()
    assert len(refused) == 5
    assert len(begun.course.stays) == 2


def test_a_restart_finds_the_same_step(clinic, begun, patient):
    begun.go(THERAPIST, "check-in", "stretch", "late")
    before = begun.course
    with open_clinic(clinic.folder) as again:
        assert again.runner.course == before
        again.runner.end(THERAPIST, "")
    assert not (clinic.folder / "live-session.json").exists()


def test_a_damaged_file_is_no_session(clinic, begun):
    (clinic.folder / "live-session.json").write_text("{")
    with open_clinic(clinic.folder) as again:
        assert again.runner.course is None


def test_what_is_kept_names_nobody(clinic, begun, patient):
    text = (clinic.folder / "live-session.json").read_text()
    assert patient in text
    assert "Clara" not in text
    assert (clinic.folder / "live-session.json").stat().st_mode & 0o077 == 0


def test_a_step_plays_what_is_prescribed_opening_first_else_a_proposal(clinic, begun, patient):
    begun.go(THERAPIST, "check-in", "active")
    (proposed,) = begun.choices()
    assert not proposed.prescribed
    assert proposed.take == clinic.takes.list()[0].id
    other = PlanItem(exercise="pinch", part="active", mode="assistive", minutes=4)
    opening = PlanItem(exercise="spread", part="active", mode="assistive", hold_s=2.0, minutes=6)
    clinic.plans.change(THERAPIST, Plan(patient=patient, items=(other, opening), reason="first"))
    found = begun.choices()
    assert [one.item.exercise for one in found] == ["spread", "pinch"]
    assert [one.take for one in found] == ["", ""]
    with pytest.raises(Refused, match="without an approved take"):
        begun.start(THERAPIST, "active", found[0].key)
    with pytest.raises(Refused, match="not chosen"):
        begun.start(THERAPIST, "active", "nonsense")
    begun.go(THERAPIST, "active", "note")
    with pytest.raises(Refused, match="without anything that moves"):
        begun.start(THERAPIST, "note")


def test_a_warm_up_starts_inside_the_limits_and_a_stretch_holds(begun):
    for key, check in (("warm-up", lambda one: one.warm_up > 0), ("stretch", lambda one: one.hold_s >= 10.0)):
        begun.go(THERAPIST, begun.course.step.key, key)
        assert all(check(choice.item) for choice in begun.choices())
        assert all(choice.item.mode == "passive" for choice in begun.choices())


def test_pain_is_written_at_once_and_a_score_corrects_it(clinic, begun, patient):
    first = begun.pain(THERAPIST)
    second = begun.pain(THERAPIST, 6, "index", first)
    held = [one for one in clinic.journal.entries(patient, ("pain",)) if not one.corrected_by]
    assert [one.id for one in held] == [second]
    assert held[0].what == PainReport(6, "index", "before")
    assert begun.course.pains == (second,)
    with pytest.raises(Refused, match="0 \\(none\\) to 10"):
        begun.pain(THERAPIST, 11)


def test_a_patient_may_enter_pain_and_say_more_about_it(clinic, begun, patient):
    first = begun.pain(PATIENT)
    begun.pain(PATIENT, 3, "", first)
    scores = [one.what.score for one in clinic.journal.entries(patient, ("pain",))]
    assert scores == [3, None]


def test_pain_in_a_demonstration_belongs_to_nobody(clinic):
    assert clinic.runner.pain(PATIENT) == 0


def test_the_note_says_what_was_done_and_the_journal_holds_no_name(clinic, begun, patient):
    begun.check_in(
        THERAPIST,
        CheckIn(pain=3, skin="red", swelling="some", botulinum_date="2020-01-31", precautions="cast"),
    )
    begun.pain(THERAPIST, 4, "thumb")
    begun.go(THERAPIST, "fit", "note", "no time")
    told = begun.note()
    assert told.heading.endswith("Clara Weber, born 1957-03-14, RIGHT hand")
    assert told.text.splitlines() == [
        "Robot-assisted hand therapy, 1 min, led by anna.",
        "Check-in: skin red; swelling some; botulinum 2020-01-31; precautions: cast.",
        "Pain: before 3/10, 4/10 (thumb); during none entered; after none entered.",
        "Nothing was run on the robot.",
        "Left out: Fit (no time), Limits, Warm-up, Stretch, Active, Task, Retest.",
    ]
    with pytest.raises(Refused, match="may not note"):
        begun.end(AUDITOR, told.text)
    begun.end(THERAPIST, told.text)
    (kept,) = clinic.journal.entries(patient, ("note",))
    assert kept.what == Note(told.text)
    assert "Weber" not in told.text
    with pytest.raises(Refused, match="not begun"):
        begun.note()


def test_a_second_check_in_corrects_the_first(clinic, begun, patient):
    begun.check_in(THERAPIST, CheckIn(pain=2))
    begun.go(THERAPIST, "fit", "check-in")
    begun.check_in(THERAPIST, CheckIn(pain=5))
    assert [
        one.what.pain for one in clinic.journal.entries(patient, ("check-in",)) if not one.corrected_by
    ] == [5]


def test_every_step_has_words_and_a_plan_of_some_minutes():
    assert sum(step.minutes for step in STEPS) == pytest.approx(46.0)
    assert all(step.words and step.told and step.minutes > 0 for step in STEPS)
