"""The next step: rules that never raise anything after trouble, and answers that are kept."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rehab_app.access import CONSOLE, Account
from rehab_app.bootstrap import open_clinic
from rehab_app.errors import Refused
from rehab_app.services.plan_items import Plan, PlanItem
from rehab_app.services.proposal_rules import LEAST, WORDS, evidence, next_step, succeeded
from sessions.catalogue import TherapySession
from sessions.reports.past import Kept, Past, Trial, past_to_json, past_version

ASSISTANT = Account("aldo", "assistant", "7")
DAY_NS = 86_400_000_000_000
MODES = ("passive", "assistive", "transparent", "resistive")
trials = st.builds(
    Trial,
    index=st.integers(0, 30),
    completed=st.booleans(),
    started_by=st.sampled_from(("patient", "robot")),
    troubles=st.lists(st.sampled_from(sorted(WORDS)), max_size=2, unique=True).map(tuple),
)
items = st.builds(
    PlanItem,
    exercise=st.just("open_close"),
    mode=st.sampled_from(MODES),
    speed=st.floats(0.1, 1.0).map(lambda value: round(value, 2)),
    support=st.sampled_from(("fixed", "as-needed")),
    stiffness_multiple=st.floats(0.5, 4.0).map(lambda value: round(value, 2)),
    resistance=st.floats(0.1, 0.8).map(lambda value: round(value, 2)),
)


def past(number, made, mode="assistive", patient="P-0001"):
    numbers = (
        Kept("range_of_motion", "index_pip", math.radians(40 + number), 0.69, 0.71, "ok", "1", "encoder"),
    )
    return Past(
        f"s{number}",
        f"{number:064x}",
        patient,
        1_700_000_000_000_000_000 + number * DAY_NS,
        "right",
        "open_close",
        (mode,),
        "stiffness 1.00 Nm/rad",
        60.0,
        "",
        (),
        numbers,
        tuple(made),
    )


def repetitions(successes, failures):
    return [
        Trial(index, True, "patient" if index < successes else "robot", ())
        for index in range(successes + failures)
    ]


@given(items, st.lists(trials, min_size=1, max_size=40), st.booleans(), st.floats(0.5, 0.9))
def test_after_trouble_nothing_is_raised(item, made, told_pain, target):
    known = evidence(item, [past(0, made, item.mode)], told_pain)
    step = next_step(item, known, target)
    if known.troubles:
        assert step.speed <= item.speed
        assert step.stiffness_multiple <= item.stiffness_multiple
        assert step.resistance <= item.resistance
        assert step.range_share <= 1.0
        assert "nothing is raised" in step.why
    assert step.why.endswith(".")
    assert 0.1 <= step.speed <= 1.0


@given(items, st.lists(trials, max_size=LEAST - 1))
def test_too_few_repetitions_say_nothing(item, made):
    calm = [Trial(one.index, one.completed, one.started_by, ()) for one in made]
    step = next_step(item, evidence(item, [past(0, calm, item.mode)]), 0.7)
    assert (step.speed, step.stiffness_multiple, step.resistance) == (
        item.speed,
        item.stiffness_multiple,
        item.resistance,
    )


@pytest.mark.parametrize(
    ("successes", "failures", "support"), [(10, 0, 1.6), (7, 3, 2.0), (3, 7, 2.5), (0, 10, 2.5)]
)
def test_success_is_brought_towards_the_target(successes, failures, support):
    item = PlanItem(exercise="open_close", mode="assistive", support="fixed", stiffness_multiple=2.0)
    step = next_step(item, evidence(item, [past(0, repetitions(successes, failures))]), 0.7)
    assert step.stiffness_multiple == pytest.approx(support)
    assert step.speed == item.speed


def test_support_that_follows_the_patient_is_left_alone_and_speed_changes_instead():
    item = PlanItem(exercise="open_close", mode="assistive", speed=0.5)
    step = next_step(item, evidence(item, [past(0, repetitions(10, 0))]), 0.7)
    assert (step.speed, step.stiffness_multiple) == (0.55, item.stiffness_multiple)


def test_a_helped_repetition_is_no_success_of_the_patient():
    assert not succeeded(Trial(0, True, "robot", ()), "assistive")
    assert succeeded(Trial(0, True, "robot", ()), "transparent")
    assert not succeeded(Trial(0, True, "patient", ("blocked",)), "transparent")
    assert not succeeded(Trial(0, False, "patient", ()), "transparent")


def test_other_modes_and_exercises_do_not_count():
    item = PlanItem(exercise="pinch", mode="assistive")
    assert evidence(item, [past(0, repetitions(9, 0))]).repetitions == 0
    other = PlanItem(exercise="open_close", mode="transparent")
    assert evidence(other, [past(0, repetitions(9, 0))]).repetitions == 0


@pytest.fixture(scope="module")
def treated(tmp_path_factory):
    """A clinic whose patient has three sessions that succeeded: numbers are kept, files are not read."""
    with open_clinic(tmp_path_factory.mktemp("treated")) as clinic:
        patient = clinic.patients.add(
            CONSOLE, given_name="Eva", family_name="Lind", birth_date="1960-02-29", side="right"
        )
        for number in range(3):
            made = past(number, repetitions(6, 0), patient=patient.id)
            clinic.catalogue.add_session(
                TherapySession(
                    patient=patient.id,
                    sha256=made.sha256,
                    path=f"sessions/{number}.mcap",
                    mode="assistive",
                    started_utc_ns=made.utc_start_ns,
                )
            )
            clinic.catalogue.keep_metrics(made.sha256, past_version(), past_to_json(made))
        item = PlanItem(exercise="open_close", mode="assistive", support="fixed", stiffness_multiple=2.0)
        clinic.plans.change(CONSOLE, Plan(patient=patient.id, items=(item,)))
        yield clinic, patient.id


def test_progress_comes_from_kept_numbers_alone(treated):
    clinic, patient = treated
    found = clinic.progress.of_patient(patient)
    assert [round(math.degrees(one.value("range_of_motion", "index_pip"))) for one in found.pasts] == [
        40,
        41,
        42,
    ]
    assert not found.left_out
    assert b"Progress" in clinic.progress.rendered(found, "html")


def test_only_a_therapist_answers(treated):
    clinic, patient = treated
    (one,) = clinic.proposals.of_patient(patient)
    with pytest.raises(Refused, match="may not prescribe"):
        clinic.proposals.answer(ASSISTANT, patient, one.digest, accept=True)
    with pytest.raises(Refused, match="may not prescribe"):
        clinic.proposals.set_target(ASSISTANT, 0.8)


def test_declined_then_accepted_changes_the_plan_once(treated):
    clinic, patient = treated
    (one,) = clinic.proposals.of_patient(patient)
    assert one.changes == (("stiffness_multiple", 2.0, 1.6),)
    clinic.proposals.answer(CONSOLE, patient, one.digest, accept=False, remark="not yet")
    (again,) = clinic.proposals.of_patient(patient)
    assert (again.digest, again.declined_by) == (one.digest, CONSOLE.name)
    assert clinic.plans.current(patient).items[0].stiffness_multiple == 2.0
    clinic.proposals.answer(CONSOLE, patient, one.digest, accept=True)
    plan = clinic.plans.current(patient)
    assert plan.items[0].stiffness_multiple == pytest.approx(1.6)
    assert "18 of the last 18 repetitions succeeded" in plan.reason
    with pytest.raises(Refused, match="no longer the one that was shown"):
        clinic.proposals.answer(CONSOLE, patient, one.digest, accept=True)
    assert [(kept.accepted, kept.remark) for kept in clinic.proposals.answers(patient)] == [
        (True, ""),
        (False, "not yet"),
    ]


@pytest.mark.parametrize("share", [0.2, 0.95, math.nan])
def test_an_aim_out_of_bounds_is_refused(treated, share):
    clinic, _ = treated
    with pytest.raises(Refused, match="aim of success"):
        clinic.proposals.set_target(CONSOLE, share)
