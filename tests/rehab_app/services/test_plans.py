"""Plans: versions, who may make them stronger, conflicts, and the take that an item plays."""

from __future__ import annotations

from dataclasses import replace

import pytest

from rehab_app.access import CONSOLE, Account
from rehab_app.bootstrap import open_clinic
from rehab_app.errors import REFUSALS, Refused
from rehab_app.services.order import Order
from rehab_app.services.plan_items import Plan, PlanItem
from rehab_app.services.plan_strength import stronger

THERAPIST = Account("anna", "therapist", "1")
ASSISTANT = Account("sam", "assistant", "2")
AUDITOR = Account("kim", "auditor", "3")
FULL = PlanItem(
    exercise="open_close", mode="assistive", repetitions=30, minutes=10.0, hold_s=2.0, warm_up=5, speed=0.6
)
STIFF = PlanItem(
    exercise="pinch", mode="resistive", support="fixed", stiffness_multiple=2.0, resistance=0.3, part="task"
)


@pytest.fixture(scope="module")
def clinic(tmp_path_factory, take_file):
    with open_clinic(tmp_path_factory.mktemp("plans")) as opened:
        opened.takes.get(take_file)
        yield opened


@pytest.fixture
def patient(clinic):
    return clinic.patients.add(
        CONSOLE, given_name="Eva", family_name="Lind", birth_date="1960-02-29", side="left"
    )


@pytest.fixture
def plan(clinic, patient):
    asked = replace(clinic.plans.current(patient.id), items=(FULL, STIFF), goal="A glass of water")
    return clinic.plans.change(THERAPIST, asked)


def with_first(plan, **changes):
    return replace(plan, items=(replace(plan.items[0], **changes), *plan.items[1:]))


def test_nothing_is_prescribed_at_first(clinic, patient):
    empty = clinic.plans.current(patient.id)
    assert (empty.version, empty.items, clinic.plans.history(patient.id)) == (0, (), ())
    with pytest.raises(Refused, match="patient"):
        clinic.plans.current("P-9999")


def test_every_change_is_a_version_with_its_author(clinic, plan):
    assert [item.key for item in plan.items] == [1, 2]
    changed = clinic.plans.change(ASSISTANT, replace(with_first(plan, repetitions=20), reason="tired"))
    assert clinic.plans.current(plan.patient) == changed
    assert [(one.by, one.reason) for one in clinic.plans.history(plan.patient)] == [
        ("sam", "tired"),
        ("anna", ""),
    ]
    assert clinic.plans.history(plan.patient)[1] == plan


def test_keys_are_never_used_twice(clinic, plan):
    fewer = clinic.plans.change(THERAPIST, replace(plan, items=plan.items[:1]))
    more = clinic.plans.change(THERAPIST, replace(fewer, items=(*fewer.items, STIFF)))
    assert [item.key for item in more.items] == [1, 3]


SAFER = [
    {"repetitions": 10, "warm_up": 5},
    {"minutes": 5.0},
    {"speed": 0.3},
    {"hold_s": 0.5},
    {"warm_up": 8},
    {"remark": "slowly"},
    {"repetitions": 3, "warm_up": 3},
]
STRONGER = [
    {"repetitions": 31},
    {"minutes": 11.0},
    {"speed": 0.7},
    {"hold_s": 2.5},
    {"warm_up": 4},
    {"mode": "passive"},
    {"mode": "resistive"},
    {"part": "stretch"},
    {"exercise": "full_fist"},
    {"support": "fixed"},
]


@pytest.mark.parametrize("change", SAFER, ids=str)
def test_safer_is_anyones_who_treats(clinic, plan, change):
    assert stronger(plan, with_first(plan, **change)) == ()
    assert clinic.plans.change(ASSISTANT, with_first(plan, **change)).by == "sam"


@pytest.mark.parametrize("change", STRONGER, ids=str)
def test_stronger_needs_the_therapist(clinic, plan, change):
    with pytest.raises(Refused, match="stronger or another treatment"):
        clinic.plans.change(ASSISTANT, with_first(plan, **change))
    assert clinic.plans.current(plan.patient) == plan
    assert clinic.plans.change(THERAPIST, with_first(plan, **change)).version > plan.version


@pytest.mark.parametrize(
    ("changes", "is_safer"),
    [
        ({"resistance": 0.2}, True),
        ({"resistance": 0.4}, False),
        ({"stiffness_multiple": 1.0}, True),
        ({"stiffness_multiple": 3.0}, False),
    ],
)
def test_softer_is_safer(plan, changes, is_safer):
    changed = replace(plan, items=(plan.items[0], replace(plan.items[1], **changes)))
    assert (stronger(plan, changed) == ()) == is_safer


@pytest.mark.parametrize(
    ("change", "is_safer"),
    [
        (lambda plan: replace(plan, items=plan.items[:1]), True),
        (lambda plan: replace(plan, items=plan.items[1:]), True),
        (lambda plan: replace(plan, items=()), True),
        (lambda plan: replace(plan, sessions_per_week=2), True),
        (lambda plan: replace(plan, sessions_per_week=4), False),
        (lambda plan: replace(plan, items=plan.items[::-1]), False),
        (lambda plan: replace(plan, items=(*plan.items, STIFF)), False),
        (lambda plan: replace(plan, items=(replace(plan.items[0], key=9), plan.items[1])), False),
        (lambda plan: replace(plan, goal="another"), True),
    ],
)
def test_of_the_whole_plan(plan, change, is_safer):
    assert (stronger(plan, change(plan)) == ()) == is_safer


def test_who_only_looks_changes_nothing(clinic, plan):
    with pytest.raises(Refused, match="may not note"):
        clinic.plans.change(AUDITOR, with_first(plan, repetitions=1, warm_up=0))


def test_the_later_of_two_is_told_who_came_first(clinic, plan):
    clinic.plans.change(ASSISTANT, with_first(plan, minutes=5.0))
    with pytest.raises(Refused, match="changed by sam meanwhile") as refused:
        clinic.plans.change(THERAPIST, with_first(plan, minutes=20.0))
    assert refused.value.remedy == "compare and save again"
    assert clinic.plans.current(plan.patient).items[0].minutes == 5.0


def test_a_change_of_nothing_is_no_version(clinic, plan):
    with pytest.raises(Refused, match="as it was"):
        clinic.plans.change(THERAPIST, replace(plan, reason="none"))


@pytest.mark.parametrize(
    "wrong",
    [
        {"minutes": 0.0},
        {"minutes": float("nan")},
        {"minutes": 121.0},
        {"repetitions": 0},
        {"repetitions": 501},
        {"speed": 0.05},
        {"hold_s": 61.0},
        {"hold_s": float("nan")},
        {"warm_up": 31},
        {"resistance": 0.9},
        {"stiffness_multiple": 11.0, "support": "fixed"},
        {"mode": "dance"},
        {"exercise": " "},
        {"remark": "x" * 10_000},
        {"remark": "a\u0000b"},
    ],
    ids=str,
)
def test_nonsense_is_refused_where_it_is_made(wrong):
    with pytest.raises(REFUSALS):
        replace(FULL, **wrong)


def test_a_plan_has_bounds():
    for wrong in ({"items": (FULL,) * 21}, {"sessions_per_week": 0}, {"goal": "x" * 3000}):
        with pytest.raises(Refused):
            Plan(patient="P-0001", **wrong)


def test_exercise_and_take_must_be_the_clinics(clinic, plan):
    take = clinic.takes.list()[0]
    for wrong in ({"exercise": "juggling"}, {"take": "ffffffff"}, {"take": take.id}):
        with pytest.raises(Refused):
            clinic.plans.change(THERAPIST, with_first(plan, **wrong))


def test_an_item_is_an_order():
    like = Order(device="dlr-hit-ii", seed=7, wrist_rad=0.1, space="fingertip")
    order = FULL.order(like)
    assert (order.device, order.seed, order.wrist_rad, order.space) == ("dlr-hit-ii", 7, 0.1, "fingertip")
    asked = order.prescription()
    assert (asked.mode, asked.repetitions, asked.minutes, asked.hold_s) == ("assistive", 30, 10.0, 2.0)
    assert (asked.warm_up_repetitions, asked.speed) == (5, 0.6)
    assert order.stiffness_multiple is None, "as needed: what is remembered of the last session counts"
    assert STIFF.order().prescription().stiffness_multiple == 2.0


def test_dose_is_minutes_and_repetitions(plan):
    assert (plan.minutes, plan.repetitions, plan.active_repetitions) == (15.0, 40, 40)
    passive = with_first(plan, mode="passive")
    assert passive.active_repetitions == 10
    assert plan.of_part("task") == (plan.items[1],)


def test_an_item_plays_the_approved_take_of_its_exercise(clinic, patient):
    row = clinic.takes.list()[0]
    clinic.exercises.add(CONSOLE, row.exercise, "imported") if row.exercise not in {
        one.name for one in clinic.exercises.list()
    } else None
    made = clinic.plans.change(
        THERAPIST, replace(clinic.plans.current(patient.id), items=(replace(FULL, exercise=row.exercise),))
    )
    assert clinic.plans.playable(made, made.items[0]) is None
    assert "no approved take" in clinic.plans.notes(made)[0]
    clinic.takes.approve(row.id, CONSOLE)
    assert clinic.plans.playable(made, made.items[0]).id == row.id
    assert clinic.plans.notes(made) == ()
    clinic.approvals.withdraw(row.id, ASSISTANT, "the thumb was hidden")
    assert clinic.plans.playable(made, made.items[0]) is None
