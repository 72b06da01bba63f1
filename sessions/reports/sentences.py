"""Three plain sentences that a patient can read."""

from __future__ import annotations

import math
import re

from sessions.metrics import Metric, Summary
from sessions.reports.language import _, counted, decimal, marked
from sessions.reports.remarks import remark
from sessions.reports.wording import exercise_words, joint_words, number, subject_name, with_unit

_DONE = {
    "passive": marked("The robot moved your hand"),
    "assistive": marked("You and the robot moved your hand"),
    "transparent": marked("You moved your hand by yourself"),
    "resistive": marked("You moved your hand against the robot"),
}
_AND = marked("%(one)s and %(other)s")


def sentences(summary: Summary) -> tuple[str, str, str]:
    """What was done, how near it came to the therapist's movement, and how far the hand moved."""
    if summary.header.kind == "take":
        return _recorded(summary), _seen(summary), _moved(summary, _("The hand"))
    return _done(summary), _near(summary), _moved(summary, _("Your hand"))


def most_moved(summary: Summary) -> Metric | None:
    """The range of the joint that moved most, None where none was measured."""
    known = [item for item in summary.named("range_of_motion") if item.measurable]
    return max(known, key=lambda item: item.value, default=None)


def stiffness_words(summary: Summary) -> str:
    """The stiffness alone, such as "stiffness 0.90 to 1.20 Nm/rad"."""
    return remark(re.split(r" \(|, ", summary.conditions, maxsplit=1)[0])


def full_repetitions(count: int) -> str:
    """Such as "1 full repetition"."""
    return counted("%(n)s full repetition", "%(n)s full repetitions", count)


def ordered_repetitions(summary: Summary) -> tuple[int, int] | None:
    """Repetitions that were completed and that were ordered; None where nobody knows the order."""
    dose = summary.metric("dose_completed")
    if dose is None or not dose.measurable or dose.value <= 0:
        return None
    completed = sum(item.completed for item in summary.repetitions)
    return completed, round(completed / dose.value)


def _recorded(summary: Summary) -> str:
    count = summary.metric("repetitions")
    times = _("an unknown number of repetitions")
    if count is not None and count.measurable:
        times = full_repetitions(round(count.value))
    return _(
        "This recording of “%(exercise)s” lasts %(seconds)s s and shows %(times)s.",
        exercise=exercise_words(summary.header.exercise),
        seconds=decimal(f"{summary.duration_s:.1f}"),
        times=times,
    )


def _seen(summary: Summary) -> str:
    shares = [item for item in summary.named("valid_share") if item.measurable]
    if not shares:
        return _("The recording does not say how well the markers were seen.")
    worst = min(shares, key=lambda item: item.value)
    if worst.value >= 0.995:
        return _("Every marked point of the hand was seen all the time.")
    share = number(worst.name, worst.unit, worst.value)
    return _(
        "The least seen marker (%(marker)s) was seen in %(share)s %% of the frames.",
        marker=subject_name(worst.subject),
        share=share,
    )


def _done(summary: Summary) -> str:
    completed = sum(item.completed for item in summary.repetitions)
    told = [_(_DONE[mode]) if mode in _DONE else mode for mode in summary.modes]
    how = told[0] if told else _("Your hand was moved")
    for other in told[1:]:
        how = _(_AND, one=how, other=other)
    ordered, planned = ordered_repetitions(summary), ""
    if ordered is not None:
        whole = ordered[0] >= ordered[1]
        planned = _(", all that were planned") if whole else _(" of %(n)s that were planned", n=ordered[1])
    stops = len(summary.stops)
    ending = counted("; it was stopped once", "; it was stopped %(n)s times", stops) if stops else ""
    return _(
        "%(how)s through %(times)s%(planned)s%(ending)s.",
        how=how,
        times=full_repetitions(completed),
        planned=planned,
        ending=ending,
    )


def _near(summary: Summary) -> str:
    error = summary.metric("fingertip_rmse")
    if error is None or not error.measurable:
        reason = error.status.partition(": ")[2] if error else "it was not measured"
        return _(
            "How near your fingers came to the therapist’s movement cannot be told: %(reason)s.",
            reason=remark(reason),
        )
    return _(
        "Your fingertips were %(error)s from the therapist’s movement on average, with the robot at "
        "%(stiffness)s.",
        error=with_unit(error),
        stiffness=stiffness_words(summary),
    )


def _moved(summary: Summary, whose: str) -> str:
    most = most_moved(summary)
    if most is None or not math.isfinite(most.value):
        return _("%(whose)s was not seen well enough to tell how far it moved.", whose=whose)
    return _(
        "%(whose)s moved most at the %(joint)s: %(angle)s from end to end.",
        whose=whose,
        joint=joint_words(most.subject),
        angle=with_unit(most),
    )
