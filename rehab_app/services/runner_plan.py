"""What a step of a session plays: items of the patient's plan, or a proposal where nothing is prescribed."""

from __future__ import annotations

from dataclasses import dataclass, replace

from rehab_app.services.clinical import Clinical
from rehab_app.services.exercises import Exercises
from rehab_app.services.order import Order
from rehab_app.services.plan_items import Part, Plan, PlanItem
from rehab_app.services.plans import Plans
from rehab_app.services.runner_steps import Step
from rehab_app.services.takes import Takes

_PROPOSED: dict[Part, PlanItem] = {
    "warm-up": PlanItem(
        exercise="?", part="warm-up", mode="passive", speed=0.4, repetitions=5, minutes=3, warm_up=5
    ),
    "stretch": PlanItem(
        exercise="?", part="stretch", mode="passive", speed=0.3, repetitions=4, minutes=5, hold_s=15.0
    ),
    "active": PlanItem(
        exercise="?", part="active", mode="assistive", speed=0.5, repetitions=20, minutes=12, hold_s=1.0
    ),
    "task": PlanItem(
        exercise="?", part="task", mode="assistive", speed=0.5, repetitions=12, minutes=10, hold_s=1.0
    ),
}
"""What is proposed for a part without a prescription [P: for a clinician to sign]."""
_OPENING = "opening"


@dataclass(frozen=True, slots=True)
class Choice:
    """Something that a step can play now.

    Attributes:
        key: Its name on the page.
        item: What is prescribed or proposed.
        words: The exercise on the screen.
        take: Catalogue id of the approved take, empty where there is none yet.
        prescribed: Whether it stands in the patient's plan.
        locked: Why its mode may not be used today, empty where it may.
    """

    key: str
    item: PlanItem
    words: str
    take: str
    prescribed: bool
    locked: str = ""

    def order(self, like: Order) -> Order:
        """The order that plays it."""
        return self.item.order(like)


class SessionPlans:
    """Finds what a step plays.

    Args:
        plans: Standing plans.
        exercises: The library.
        takes: What can be played.
        clinical: What is locked.
    """

    def __init__(self, plans: Plans, exercises: Exercises, takes: Takes, clinical: Clinical) -> None:
        self._plans = plans
        self._exercises = exercises
        self._takes = takes
        self._clinical = clinical

    def choices(self, patient_id: str, step: Step) -> tuple[Choice, ...]:
        """What the step can play for the patient, opening movements first.

        Raises:
            Refused: There is no such patient.
        """
        if step.part is None:
            return ()
        plan = self._plans.current(patient_id)
        locks = self._clinical.locks(patient_id)
        items = plan.of_part(step.part)
        found = [self._choice(plan, item, locks) for item in items] or self._proposed(plan, step.part, locks)
        return tuple(sorted(found, key=lambda one: not self._opens(one.item.exercise)))

    def _proposed(self, plan: Plan, part: Part, locks: dict[str, str]) -> list[Choice]:
        """The usual order for the newest approved take of each exercise, of the patient's side first."""
        names = self._takes.shelf.counts(approved=True)
        return [
            replace(self._choice(plan, replace(_PROPOSED[part], exercise=name), locks), prescribed=False)
            for name in names
            if name
        ]

    def _choice(self, plan: Plan, item: PlanItem, locks: dict[str, str]) -> Choice:
        take = self._plans.playable(plan, item)
        return Choice(
            key=f"{item.key}-{item.exercise}",
            item=item,
            words=self._exercises.words(item.exercise),
            take="" if take is None else take.id,
            prescribed=True,
            locked=locks.get(item.mode, ""),
        )

    def _opens(self, name: str) -> bool:
        return any(one.name == name and _OPENING in one.purposes for one in self._exercises.list())
