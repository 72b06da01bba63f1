"""The form of one item of a plan: numbers as people write them, and the item that they say."""

from __future__ import annotations

from rehab_app.services.plan_items import PlanItem, part_named, support_named
from rehab_app.web.language import marked, written
from rehab_app.web.pages.asked import number, whole
from rehab_app.web.pages.recordings import catalogue_id
from rehab_app.web.visit import Visit

ITEM_FIELDS = (
    "key",
    "exercise",
    "take",
    "part",
    "mode",
    "speed",
    "repetitions",
    "minutes",
    "hold_s",
    "warm_up",
    "support",
    "stiffness",
    "resistance",
    "remark",
    "reason",
)
PART_WORDS = {
    "warm-up": marked("Warm-up"),
    "stretch": marked("Slow stretch"),
    "active": marked("Active-assisted part"),
    "task": marked("Task practice"),
}
SUPPORT_WORDS = {
    "as-needed": marked("As needed: follows the patient's ability"),
    "fixed": marked("Fixed: stays as stated"),
}


def typed_item(visit: Visit) -> dict[str, str]:
    """What was typed, for the form that is shown again."""
    return {name: visit.asked(name) for name in ITEM_FIELDS}


def shown_item(item: PlanItem) -> dict[str, str]:
    """An item as the form shows it: percent where people read percent."""
    return {
        "key": str(item.key),
        "exercise": item.exercise,
        "take": item.take,
        "part": item.part,
        "mode": item.mode,
        "speed": written(100.0 * item.speed),
        "repetitions": str(item.repetitions),
        "minutes": written(item.minutes),
        "hold_s": written(item.hold_s),
        "warm_up": str(item.warm_up),
        "support": item.support,
        "stiffness": written(item.stiffness_multiple),
        "resistance": written(100.0 * item.resistance),
        "remark": item.remark,
        "reason": "",
    }


def item_of(visit: Visit) -> PlanItem:
    """The item that was typed.

    Raises:
        Refused: Something is no number, not on its list or out of bounds.
    """
    return PlanItem(
        key=whole(visit, "key", "item of the plan", 0),
        exercise=visit.asked("exercise"),
        take=catalogue_id(visit.asked("take")) if visit.asked("take") else "",
        part=part_named(visit.asked("part")),
        mode=visit.asked("mode"),
        speed=number(visit, "speed", "speed", "10 to 100 %") / 100.0,
        repetitions=whole(visit, "repetitions", "repetitions"),
        minutes=number(visit, "minutes", "minutes", "1 to 120"),
        hold_s=number(visit, "hold_s", "hold", "0 to 60 s", 0.0),
        warm_up=whole(visit, "warm_up", "warm-up repetitions", 0),
        support=support_named(visit.asked("support")),
        stiffness_multiple=number(visit, "stiffness", "stiffness", "0.1 to 10", 3.0),
        resistance=number(visit, "resistance", "resistance", "5 to 80 %", 30.0) / 100.0,
        remark=visit.asked("remark"),
    )
