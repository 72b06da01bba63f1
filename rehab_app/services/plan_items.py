"""A patient's standing plan and its items: values, checked where they are made."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal, TypeAlias, get_args

from rehab_app.errors import Refused
from rehab_app.services.order import Order
from rehab_app.services.plain_text import many_lines

Part: TypeAlias = Literal["warm-up", "stretch", "active", "task"]
PARTS: tuple[Part, ...] = get_args(Part)
"""Steps of a session that an item may belong to, in the order in which they come."""
Support: TypeAlias = Literal["as-needed", "fixed"]
SUPPORTS: tuple[Support, ...] = get_args(Support)
MOST_ITEMS = 20
MOST_PER_WEEK = 14
LONGEST_TEXT = 2000
USUAL_STIFFNESS = 3.0


@dataclass(frozen=True, slots=True, kw_only=True)
class PlanItem:
    """One exercise of a plan.

    Attributes:
        key: Number of the item in the plans of its patient, 0 while new; it stays when the item changes.
        exercise: Name of the exercise in the library.
        take: Catalogue id of the take to play, empty for the newest approved one of the exercise.
        part: Step of the session.
        mode: Therapy mode.
        speed: Path speed, 0.1 to 1 of the therapist's own.
        repetitions: How many times at most.
        minutes: Time after which no repetition begins; minutes and repetitions are both prescribed.
        hold_s: Time held at the end of each repetition.
        warm_up: First repetitions with less range.
        support: Whether stiffness follows the patient (as-needed) or stays at ``stiffness_multiple`` (fixed).
        stiffness_multiple: Of the thesis gains; where support is as needed it is only what begins.
        resistance: Resistive: share of the interaction limit.
        remark: A sentence for whoever treats.

    Raises:
        Refused: A word or number is out of bounds.
    """

    key: int = 0
    exercise: str
    take: str = ""
    part: Part = "active"
    mode: str = "passive"
    speed: float = 0.5
    repetitions: int = 10
    minutes: float = 5.0
    hold_s: float = 0.5
    warm_up: int = 0
    support: Support = "as-needed"
    stiffness_multiple: float = USUAL_STIFFNESS
    resistance: float = 0.3
    remark: str = ""

    def __post_init__(self) -> None:
        thing = f"prescribed {self.exercise[:40]}".rstrip()
        change = "change the prescription"
        if not self.exercise.strip():
            raise Refused("exercise of the prescription", "empty", "one of the library", "choose one")
        if not (math.isfinite(self.minutes) and 1.0 <= self.minutes <= 120.0):
            raise Refused(f"minutes of {thing}", f"{self.minutes:g}", "1 to 120", change)
        if not 0 <= self.warm_up <= self.repetitions:
            bound = f"0 to the {self.repetitions} repetitions"
            raise Refused(f"warm-up of {thing}", str(self.warm_up), bound, change)
        object.__setattr__(self, "remark", many_lines(f"remark of {thing}", self.remark, LONGEST_TEXT))
        self.order().prescription()  # refuses every other number

    def order(self, like: Order | None = None) -> Order:
        """What the item asks for, as therapy takes it.

        Args:
            like: Where device, virtual patient, seed, wrist and clock come from; by default a plain order.
        """
        return replace(
            Order() if like is None else like,
            mode=self.mode,
            speed=self.speed,
            repetitions=self.repetitions,
            minutes=self.minutes,
            hold_s=self.hold_s,
            warm_up=self.warm_up,
            resistance=self.resistance,
            stiffness_multiple=None if self.support == "as-needed" else self.stiffness_multiple,
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Plan:
    """The standing plan of a patient.

    Attributes:
        patient: Pseudonym.
        items: Exercises in the order in which they are done.
        sessions_per_week: How often.
        goal: What it is for, in the patient's and therapist's words.
        remark: Anything else.
        reason: Why this version was made.
        version: Number of this version, 0 while nobody prescribed anything.
        by: Who made this version.
        created_utc_ns: When.

    Raises:
        Refused: A number is out of bounds, a text too long, or two items share a key.
    """

    patient: str
    items: tuple[PlanItem, ...] = ()
    sessions_per_week: int = 3
    goal: str = ""
    remark: str = ""
    reason: str = ""
    version: int = 0
    by: str = ""
    created_utc_ns: int = 0

    def __post_init__(self) -> None:
        if len(self.items) > MOST_ITEMS:
            raise Refused(
                "plan", f"{len(self.items)} items long", f"at most {MOST_ITEMS} items", "leave some out"
            )
        if not 1 <= self.sessions_per_week <= MOST_PER_WEEK:
            value, bound = str(self.sessions_per_week), f"1 to {MOST_PER_WEEK}"
            raise Refused("sessions per week", value, bound, "change the prescription")
        for name, text in (("goal", self.goal), ("remark", self.remark), ("reason", self.reason)):
            object.__setattr__(self, name, many_lines(f"{name} of the plan", text, LONGEST_TEXT))
        keys = [item.key for item in self.items if item.key]
        if len(set(keys)) != len(keys):
            raise Refused("items of the plan", "numbered alike", "numbered once each", "load the page again")

    @property
    def minutes(self) -> float:
        """Minutes of all items together."""
        return sum(item.minutes for item in self.items)

    @property
    def repetitions(self) -> int:
        """Repetitions of all items together."""
        return sum(item.repetitions for item in self.items)

    @property
    def active_repetitions(self) -> int:
        """Repetitions that the patient takes part in: all but the passive ones."""
        return sum(item.repetitions for item in self.items if item.mode != "passive")

    def of_part(self, part: Part) -> tuple[PlanItem, ...]:
        """Items of one step of the session, in order."""
        return tuple(item for item in self.items if item.part == part)


def part_named(name: str) -> Part:
    """The step of a session of that name.

    Raises:
        Refused: There is none.
    """
    for part in PARTS:
        if part == name:
            return part
    raise Refused("part of the session", repr(name[:40]), "one of " + ", ".join(PARTS), "choose one")


def support_named(name: str) -> Support:
    """The policy of support of that name.

    Raises:
        Refused: There is none.
    """
    for support in SUPPORTS:
        if support == name:
            return support
    raise Refused("support", repr(name[:40]), "one of " + ", ".join(SUPPORTS), "choose one")
