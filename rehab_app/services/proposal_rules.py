"""What the last repetitions of an exercise say of the next ones: pure rules, one change at a time.

Blocked, opposed, reversed or painful repetitions never raise anything: contracture is not weakness. Where
none of these happened, the share of successful repetitions is brought towards a target, 70 % by default:
enough success to go on, enough failure to learn from.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from rehab_app.services.plan_items import PlanItem
from sessions.reports.past import Past, Trial

WINDOW = 30
"""Repetitions that count: the latest ones."""
LEAST = 5
"""Fewer say nothing."""
BAND = 0.15
"""Nearer to the target than this nothing is changed."""
SLOWER, FASTER = 0.8, 1.1
LESS_SUPPORT, MORE_SUPPORT = 0.8, 1.25
LEAST_SPEED, MOST_SPEED = 0.1, 1.0
LEAST_SUPPORT, MOST_SUPPORT = 0.5, 4.0
RESISTANCE_STEP = 0.1
MOST_RESISTANCE = 0.8
NARROWER = 0.9
WORDS = {
    "pain": "pain was told",
    "reversed": "a load reversed the movement",
    "blocked": "the movement was blocked",
    "opposed": "helping more met more load",
}
_NOTHING = "nothing is proposed"


@dataclass(frozen=True, slots=True)
class Evidence:
    """What the latest repetitions were.

    Attributes:
        repetitions: How many count.
        successes: How many of them succeeded.
        troubled: How many of the last five met a trouble.
        troubles: Which troubles occurred among those that count, commonest first.
        sessions: Ids of the sessions they are from, oldest first.
    """

    repetitions: int
    successes: int
    troubled: int
    troubles: tuple[str, ...]
    sessions: tuple[str, ...]

    @property
    def success(self) -> float:
        """Share of successes, 0 without repetitions."""
        return self.successes / self.repetitions if self.repetitions else 0.0


@dataclass(frozen=True, slots=True)
class Step:
    """The next step for one item of a plan.

    Attributes:
        speed: Path speed.
        stiffness_multiple: Support, as a multiple of the thesis gains.
        resistance: Share of the interaction limit.
        range_share: Part of the movement that is to be played; below 1 the take must be scaled down.
        why: One sentence.
    """

    speed: float
    stiffness_multiple: float
    resistance: float
    range_share: float
    why: str


def evidence(item: PlanItem, pasts: Sequence[Past], told_pain: bool = False) -> Evidence:
    """Gather the latest repetitions of an item's exercise in its mode.

    Args:
        item: The item.
        pasts: Sessions, oldest first.
        told_pain: Whether strong or rising pain was told since the last session.
    """
    alike = [
        past
        for past in pasts
        if past.exercise == item.exercise and past.modes == (item.mode,) and past.trials
    ]
    trials = [(past.session_id, trial) for past in alike for trial in past.trials][-WINDOW:]
    found = [trouble for _, trial in trials for trouble in trial.troubles]
    found += ["pain"] if told_pain else []
    troubles = sorted(dict.fromkeys(found), key=lambda word: -found.count(word))
    return Evidence(
        len(trials),
        sum(succeeded(trial, item.mode) for _, trial in trials),
        sum(bool(trial.troubles) for _, trial in trials[-5:]) + told_pain,
        tuple(troubles),
        tuple(dict.fromkeys(session for session, _ in trials)),
    )


def succeeded(trial: Trial, mode: str) -> bool:
    """Whether a repetition came to its end without trouble and, in assistive mode, was the patient's own."""
    if not trial.completed or trial.troubles:
        return False
    return mode != "assistive" or trial.started_by == "patient"


def next_step(item: PlanItem, known: Evidence, target: float) -> Step:
    """What is proposed; a step whose numbers are the item's own proposes nothing, and says why.

    Args:
        item: What is prescribed.
        known: What happened.
        target: Share of successes that is aimed at.
    """
    if known.troubles:
        return _safer(item, known)
    if known.repetitions < LEAST:
        count = f"only {known.repetitions}" if known.repetitions else "none"
        made = f"at least {LEAST} repetitions of this exercise in this mode are needed, {count} so far"
        return _same(item, f"{made}: {_NOTHING}.")
    if item.mode == "passive":
        return _same(item, f"The robot moves the hand, so no success can be counted: {_NOTHING}.")
    said = (
        f"{known.successes} of the last {known.repetitions} repetitions succeeded "
        f"({100 * known.success:.0f} %, aim {100 * target:.0f} %)"
    )
    if known.success >= min(target + BAND, 0.99):
        return _harder(item, said)
    if known.success <= target - BAND:
        return _easier(item, said)
    return _same(item, f"{said}: near the aim, so {_NOTHING}.")


def _safer(item: PlanItem, known: Evidence) -> Step:
    """Never more of anything; slower, and less range where load opposed the movement again and again."""
    what = " and ".join(WORDS[word] for word in known.troubles)
    often = known.troubled >= 2 or "pain" in known.troubles
    if not often:
        return _same(item, f"In the last repetitions {what}: nothing is raised.")
    loaded = any(word != "pain" for word in known.troubles)
    share = NARROWER if loaded else 1.0
    narrower = f" and through {100 * NARROWER:.0f} % of its range" if loaded else ""
    why = f"In the last repetitions {what}: slower{narrower} is proposed, and nothing is raised."
    return Step(_speed(item.speed * SLOWER), item.stiffness_multiple, item.resistance, share, why)


def _harder(item: PlanItem, said: str) -> Step:
    if item.mode == "assistive" and item.support == "fixed" and item.stiffness_multiple > LEAST_SUPPORT:
        support = max(LEAST_SUPPORT, round(item.stiffness_multiple * LESS_SUPPORT, 2))
        return Step(item.speed, support, item.resistance, 1.0, f"{said}: less support is proposed.")
    if item.mode == "resistive" and item.resistance < MOST_RESISTANCE:
        resistance = min(MOST_RESISTANCE, round(item.resistance + RESISTANCE_STEP, 2))
        why = f"{said}: more resistance is proposed."
        return Step(item.speed, item.stiffness_multiple, resistance, 1.0, why)
    if item.speed < MOST_SPEED:
        faster = _speed(item.speed * FASTER)
        return Step(faster, item.stiffness_multiple, item.resistance, 1.0, f"{said}: faster is proposed.")
    return _same(
        item, f"{said}, at full speed already: another exercise or mode is for a therapist to choose."
    )


def _easier(item: PlanItem, said: str) -> Step:
    if item.mode == "assistive" and item.support == "fixed" and item.stiffness_multiple < MOST_SUPPORT:
        support = min(MOST_SUPPORT, round(item.stiffness_multiple * MORE_SUPPORT, 2))
        return Step(item.speed, support, item.resistance, 1.0, f"{said}: more support is proposed.")
    if item.mode == "resistive" and item.resistance > RESISTANCE_STEP:
        resistance = round(item.resistance - RESISTANCE_STEP, 2)
        why = f"{said}: less resistance is proposed."
        return Step(item.speed, item.stiffness_multiple, resistance, 1.0, why)
    if item.speed > LEAST_SPEED:
        slower = _speed(item.speed * SLOWER)
        return Step(slower, item.stiffness_multiple, item.resistance, 1.0, f"{said}: slower is proposed.")
    return _same(item, f"{said}, at the least speed already: another exercise is for a therapist to choose.")


def _same(item: PlanItem, why: str) -> Step:
    return Step(item.speed, item.stiffness_multiple, item.resistance, 1.0, why[:1].upper() + why[1:])


def _speed(value: float) -> float:
    return min(MOST_SPEED, max(LEAST_SPEED, round(value, 2)))
