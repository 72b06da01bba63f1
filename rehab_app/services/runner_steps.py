"""The steps of a session in the order in which the live page leads through them, and what was done."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

from rehab_app.errors import Refused
from rehab_app.services.plan_items import Part

StepKey: TypeAlias = Literal[
    "check-in", "fit", "limits", "warm-up", "stretch", "active", "task", "retest", "note"
]
Starts: TypeAlias = Literal["", "fit", "range", "play"]
When: TypeAlias = Literal["before", "during", "after"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Step:
    """One step of a session.

    Attributes:
        key: Its name in files.
        words: Its name on the screen, English.
        minutes: How long it is planned to take [P].
        told: What is to be done, one or two sentences, English.
        starts: Which kind of run it starts, empty for none.
        part: Which items of the plan it plays, None for none.
        when: When a pain is felt that is entered in it.
    """

    key: StepKey
    words: str
    minutes: float
    told: str
    starts: Starts = ""
    part: Part | None = None
    when: When = "during"


def marked(text: str) -> str:
    """Marks a text for the catalogues of languages; pages translate it."""
    return text


STEPS: tuple[Step, ...] = (
    Step(
        key="check-in",
        words=marked("Check-in"),
        minutes=3,
        told=marked("Ask about pain, look at the skin and the swelling, ask for anything new."),
        when="before",
    ),
    Step(
        key="fit",
        words=marked("Fit"),
        minutes=5,
        told=marked("Put the device on and align it, then let it check every joint."),
        starts="fit",
        when="before",
    ),
    Step(
        key="limits",
        words=marked("Limits"),
        minutes=3,
        told=marked("Measure today's range: open, tabletop, hook and fist. It holds until midnight."),
        starts="range",
        when="before",
    ),
    Step(
        key="warm-up",
        words=marked("Warm-up"),
        minutes=3,
        told=marked("Passive and easy: it begins 10 degrees inside today's limits and grows by 2 a cycle."),
        starts="play",
        part="warm-up",
    ),
    Step(
        key="stretch",
        words=marked("Stretch"),
        minutes=5,
        told=marked("Slow, held for 10 to 30 s. A pull may be felt; it must not hurt."),
        starts="play",
        part="stretch",
    ),
    Step(
        key="active",
        words=marked("Active"),
        minutes=12,
        told=marked("Active-assisted, opening before closing: the patient starts, the robot helps."),
        starts="play",
        part="active",
    ),
    Step(
        key="task",
        words=marked("Task"),
        minutes=10,
        told=marked("Practise with a real object in the hand."),
        starts="play",
        part="task",
    ),
    Step(
        key="retest",
        words=marked("Retest"),
        minutes=3,
        told=marked("Measure the range again, take the device off, look at the skin, ask about pain."),
        starts="range",
        when="after",
    ),
    Step(
        key="note",
        words=marked("Note"),
        minutes=2,
        told=marked("Read the note, change what is wrong, copy it into the clinic's record."),
        when="after",
    ),
)
KEYS: tuple[StepKey, ...] = tuple(step.key for step in STEPS)


def step_named(key: str) -> Step:
    """The step of that name.

    Raises:
        Refused: There is none.
    """
    for step in STEPS:
        if step.key == key:
            return step
    raise Refused("step", repr(key[:20]), "one of " + ", ".join(KEYS), "choose one of the session")


@dataclass(frozen=True, slots=True, kw_only=True)
class Stay:
    """A time in which one step was shown.

    Attributes:
        step: Which.
        began_utc_ns: From when.
        ended_utc_ns: Until when, 0 while it is shown.
        skipped: Whether it was left as not done.
        reason: Why, may be empty.
    """

    step: StepKey
    began_utc_ns: int
    ended_utc_ns: int = 0
    skipped: bool = False
    reason: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Course:
    """A session that goes on.

    Attributes:
        patient: Pseudonym.
        by: Who began it.
        began_utc_ns: When.
        stays: Steps in the order in which they were shown; the last one is shown now.
        check_in: Number of the check-in in the journal, 0 before it.
        pains: Numbers of the pains in the journal that were entered in it.
        version: Counts changes.
    """

    patient: str
    by: str
    began_utc_ns: int
    stays: tuple[Stay, ...]
    check_in: int = 0
    pains: tuple[int, ...] = ()
    version: int = 1

    @property
    def step(self) -> Step:
        """The step that is shown."""
        return step_named(self.stays[-1].step)

    def spent_s(self, key: StepKey, now_utc_ns: int) -> float:
        """How long a step was shown so far, s."""
        return 1e-9 * sum(
            max((stay.ended_utc_ns or now_utc_ns) - stay.began_utc_ns, 0)
            for stay in self.stays
            if stay.step == key
        )

    def state_of(self, key: StepKey) -> Literal["now", "done", "skipped", "open"]:
        """Where a step stands: shown now, done, left out, or still to come."""
        if self.stays[-1].step == key:
            return "now"
        last = next((stay for stay in reversed(self.stays) if stay.step == key), None)
        if last is None:
            return "skipped" if KEYS.index(key) < KEYS.index(self.step.key) else "open"
        return "skipped" if last.skipped else "done"
