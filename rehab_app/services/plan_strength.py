"""What of a changed plan is stronger than it was, or another treatment: that needs a therapist."""

from __future__ import annotations

from rehab_app.services.plan_items import Plan, PlanItem

_MORE = (
    ("speed", "faster"),
    ("repetitions", "more repetitions"),
    ("minutes", "more minutes"),
    ("hold_s", "a longer hold"),
)
_ANOTHER = (("exercise", "exercise"), ("take", "take"), ("part", "step of the session"), ("mode", "mode"))


def stronger(before: Plan, after: Plan) -> tuple[str, ...]:
    """What makes a plan more than the one before it, one short sentence each; empty where nothing does.

    Fewer or shorter is safer: fewer items, repetitions, minutes or sessions, slower, more warm-up, less hold,
    resistance or stiffness. Words may be changed freely.
    """
    known = {item.key: item for item in before.items}
    said: list[str] = []
    if before.version and after.sessions_per_week > before.sessions_per_week:
        said.append(f"{after.sessions_per_week} sessions a week, {before.sessions_per_week} before")
    for item in after.items:
        old = known.get(item.key) if item.key else None
        if old is None:
            said.append(f"{item.exercise} is new")
        else:
            said += [f"{item.exercise}: {what}" for what in _stronger_item(old, item)]
    kept = [item.key for item in after.items if item.key in known]
    if kept != [key for key in known if key in kept]:
        said.append("another order of the exercises")
    return tuple(said)


def _stronger_item(old: PlanItem, new: PlanItem) -> list[str]:
    said = [f"another {words}" for name, words in _ANOTHER if getattr(old, name) != getattr(new, name)]
    said += [words for name, words in _MORE if getattr(new, name) > getattr(old, name)]
    if new.warm_up < min(old.warm_up, new.repetitions):
        said.append("less warm-up")
    if new.mode == "resistive" and new.resistance > old.resistance:
        said.append("more resistance")
    if new.support != old.support:
        said.append("another support")
    elif new.support == "fixed" and new.stiffness_multiple > old.stiffness_multiple:
        said.append("stiffer support")
    return said
