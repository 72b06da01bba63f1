"""The plan of a patient: what is prescribed, changed item by item, each change a version."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from starlette.responses import Response

from rehab_app.errors import REFUSALS, Refused
from rehab_app.services.exercise_records import Exercise
from rehab_app.services.plan_items import MOST_PER_WEEK, Plan, PlanItem
from rehab_app.services.rows import TakeRow
from rehab_app.web.language import _
from rehab_app.web.pages.asked import choice, whole
from rehab_app.web.pages.choices import take_choices
from rehab_app.web.pages.patient_tabs import patient_head
from rehab_app.web.pages.plan_form import PART_WORDS, SUPPORT_WORDS, item_of, shown_item, typed_item
from rehab_app.web.visit import Visit
from rehab_app.web.words import MODES

_MOVES = ("up", "down", "remove")
_VERSIONS = 12


@dataclass(frozen=True, slots=True)
class ShownItem:
    """An item with what a page says of it.

    Attributes:
        item: The item.
        words: Name of its exercise.
        take: The approved take that it plays now, None where there is none.
        mirrored: Whether that take is of the other hand.
    """

    item: PlanItem
    words: str
    take: TakeRow | None
    mirrored: bool


def plan(visit: Visit) -> Response:
    """The plan that holds, with the item that is to be changed or added."""
    asked = visit.request.query_params
    clinic = visit.site.clinic
    current = clinic.plans.current(visit.part("patient"))
    if "add" in asked:
        known = clinic.exercises.list()
        first = clinic.exercises.get(asked["add"]) if asked["add"] else known[0]
        return _page(visit, current, item=shown_item(_suggested(first, asked.get("take", ""))))
    found = [item for item in current.items if str(item.key) == asked.get("edit", "")]
    return _page(visit, current, item=shown_item(found[0]) if found else None)


def save_item(visit: Visit) -> Response:
    """Change an item, or add one."""

    def changed(base: Plan) -> Plan:
        item = item_of(visit)
        if not item.key:
            return replace(base, items=(*base.items, item))
        _position(base, item.key)
        return replace(base, items=tuple(item if old.key == item.key else old for old in base.items))

    return _changed(visit, changed, item=typed_item(visit))


def move_item(visit: Visit) -> Response:
    """Move an item up or down, or take it out of the plan."""

    def changed(base: Plan) -> Plan:
        how = choice(visit.asked("how"), "change of the plan", _MOVES)
        row = _position(base, whole(visit, "key", "item of the plan"))
        items = list(base.items)
        moved = items.pop(row)
        if how != "remove":
            items.insert(max(0, row + (-1 if how == "up" else 1)), moved)
        return replace(base, items=tuple(items))

    return _changed(visit, changed)


def save_frame(visit: Visit) -> Response:
    """Change goal, frequency and remark."""

    def changed(base: Plan) -> Plan:
        return replace(
            base,
            sessions_per_week=whole(visit, "sessions_per_week", "sessions per week"),
            goal=visit.asked("goal"),
            remark=visit.asked("remark"),
        )

    typed = {name: visit.asked(name) for name in ("sessions_per_week", "goal", "remark")}
    return _changed(visit, changed, frame=typed)


def _changed(
    visit: Visit,
    change: Callable[[Plan], Plan],
    item: dict[str, str] | None = None,
    frame: dict[str, str] | None = None,
) -> Response:
    """Make a version, or show the page again with what was typed and why it was refused."""
    plans, patient = visit.site.clinic.plans, visit.part("patient")
    try:
        base = replace(
            plans.current(patient), version=whole(visit, "version", "version"), reason=visit.asked("reason")
        )
        plans.change(visit.account, change(base))
    except REFUSALS as refusal:
        return _page(visit, plans.current(patient), item=item, frame=frame, sentence=str(refusal))
    return visit.go(f"/patients/{patient}/plan", _("The plan is changed."))


def _page(
    visit: Visit,
    current: Plan,
    item: dict[str, str] | None = None,
    frame: dict[str, str] | None = None,
    sentence: str = "",
) -> Response:
    clinic = visit.site.clinic
    patient = clinic.patients.get(current.patient)
    playables = clinic.plans.playables(current)
    usual = {
        "sessions_per_week": str(current.sessions_per_week),
        "goal": current.goal,
        "remark": current.remark,
    }
    return visit.page(
        "plan.html.j2",
        say=_,
        status=409 if sentence else 200,
        patient=patient,
        head=patient_head(visit, patient, "plan"),
        plan=current,
        shown=_shown(visit, current, playables, patient.side),
        notes=clinic.plans.notes(current, playables),
        history=clinic.plans.history(patient.id, _VERSIONS),
        item=item,
        frame=frame or usual,
        framing=frame is not None,
        sentence=sentence,
        exercises=clinic.exercises.list(),
        takes=None if item is None else take_choices(visit, kept=item["take"], exercise=item["exercise"]),
        modes=MODES,
        parts=PART_WORDS,
        supports=SUPPORT_WORDS,
        most_per_week=MOST_PER_WEEK,
    )


def _shown(visit: Visit, current: Plan, playables: tuple[TakeRow | None, ...], side: str) -> list[ShownItem]:
    clinic = visit.site.clinic
    return [
        ShownItem(item, clinic.exercises.words(item.exercise), take, take is not None and take.side != side)
        for item, take in zip(current.items, playables, strict=True)
    ]


def _suggested(exercise: Exercise, take: str) -> PlanItem:
    """A new item with the dose that the library proposes."""
    dose = exercise.dose
    return PlanItem(
        exercise=exercise.name,
        take=take,
        part=dose.part,
        mode=dose.mode,
        repetitions=dose.repetitions,
        minutes=dose.minutes,
        hold_s=dose.hold_s,
    )


def _position(plan: Plan, key: int) -> int:
    """Row of an item.

    Raises:
        Refused: It is not in the plan any more.
    """
    keys = [item.key for item in plan.items]
    if key not in keys:
        raise Refused("item of the plan", "no longer there", "one of the plan", "add it as a new one")
    return keys.index(key)
