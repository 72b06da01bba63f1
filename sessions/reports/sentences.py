"""Three plain sentences that a patient can read."""

from __future__ import annotations

import math

from sessions.metrics import Metric, Summary
from sessions.reports.wording import joint_words, number, plural, with_unit

_DONE = {
    "passive": "The robot moved your hand",
    "assistive": "You and the robot moved your hand",
    "transparent": "You moved your hand by yourself",
    "resistive": "You moved your hand against the robot",
}


def sentences(summary: Summary) -> tuple[str, str, str]:
    """What was done, how near it came to the therapist's movement, and how far the hand moved."""
    if summary.header.kind == "take":
        return _recorded(summary), _seen(summary), _moved(summary, "The hand")
    return _done(summary), _near(summary), _moved(summary, "Your hand")


def most_moved(summary: Summary) -> Metric | None:
    """The range of the joint that moved most, None where none was measured."""
    known = [item for item in summary.named("range_of_motion") if item.measurable]
    return max(known, key=lambda item: item.value, default=None)


def _recorded(summary: Summary) -> str:
    count = summary.metric("repetitions")
    times = "an unknown number of repetitions"
    if count is not None and count.measurable:
        times = plural(round(count.value), "full repetition")
    return (
        f"This recording of “{summary.header.exercise}” lasts {summary.duration_s:.1f} s and shows {times}."
    )


def _seen(summary: Summary) -> str:
    shares = [item for item in summary.named("valid_share") if item.measurable]
    if not shares:
        return "The recording does not say how well the markers were seen."
    worst = min(shares, key=lambda item: item.value)
    if worst.value >= 0.995:
        return "Every marker was seen all the time."
    marker = worst.subject.replace("_", " ")
    share = number(worst.name, worst.unit, worst.value)
    return f"The least seen marker ({marker}) was seen in {share} % of the frames."


def _done(summary: Summary) -> str:
    completed = sum(item.completed for item in summary.repetitions)
    how = " and ".join(_DONE.get(mode, mode) for mode in summary.modes) or "Your hand was moved"
    dose = summary.metric("dose_completed")
    planned = ""
    if dose is not None and dose.measurable and dose.value > 0:
        ordered = round(completed / dose.value)
        planned = ", all that were planned" if completed >= ordered else f" of {ordered} that were planned"
    stops = len(summary.stops)
    ending = f"; it was stopped {'once' if stops == 1 else f'{stops} times'}" if stops else ""
    return f"{how} through {plural(completed, 'full repetition')}{planned}{ending}."


def _near(summary: Summary) -> str:
    error = summary.metric("fingertip_rmse")
    if error is None or not error.measurable:
        reason = error.status.partition(": ")[2] if error else "it was not measured"
        return f"How near your fingers came to the therapist’s movement cannot be told: {reason}."
    return (
        f"Your fingertips were {with_unit(error)} from the therapist’s movement on average, "
        f"while the robot was set to {summary.conditions}."
    )


def _moved(summary: Summary, whose: str) -> str:
    most = most_moved(summary)
    if most is None or not math.isfinite(most.value):
        return f"{whose} was not seen well enough to tell how far it moved."
    return f"{whose} moved most at the {joint_words(most.subject)}: {with_unit(most)} from end to end."
