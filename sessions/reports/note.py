"""A short note in plain text, to be pasted into the clinic's own record."""

from __future__ import annotations

from sessions.metrics import Metric, Summary
from sessions.reports.dated import recorded
from sessions.reports.language import _, counted, decimal
from sessions.reports.remarks import remark
from sessions.reports.report import Report
from sessions.reports.sentences import full_repetitions, most_moved, ordered_repetitions, sentences
from sessions.reports.wording import (
    capital,
    exercise_words,
    hand,
    interval,
    joint_name,
    unit_shown,
    with_unit,
)

MOST_JOINTS = 4
LEAST_RAD = 0.0873
"""5 degrees: joints that moved less do not stand in a note."""


def render_note(report: Report) -> str:
    """At most a dozen short lines per file: what was done, how far it went, what must be known beside it."""
    return "\n\n".join(_note(summary) for summary in report.summaries) + "\n"


def _note(summary: Summary) -> str:
    header = summary.header
    take = header.kind == "take"
    kind = _("Recorded movement") if take else _("Robot-assisted hand therapy")
    unnamed = _("Hand not named")
    lines = [
        f"{kind}, {recorded(header)}. {header.subject_id or unnamed}, {hand(header.side)}. "
        f"{capital(exercise_words(header.exercise))}.",
        *(sentences(summary)[:2] if take else (_done(summary), _error(summary))),
        *_dose(summary),
        *_ranges(summary),
        *(
            _("Stop at %(seconds)s s: %(why)s", seconds=f"{stop.t_s:.0f}", why=stop.text or stop.cause)
            for stop in summary.stops
        ),
        _("Not a certified medical device. File %(digest)s.", digest=summary.sha256[:12]),
    ]
    return "\n".join(lines)


def _done(summary: Summary) -> str:
    """What the clinician needs of what a patient is told in sentences."""
    modes = ", ".join(_(mode) for mode in summary.modes) or _("not recorded")
    ordered = ordered_repetitions(summary)
    made = full_repetitions(sum(item.completed for item in summary.repetitions))
    of = "" if ordered is None else _(", %(n)s ordered", n=ordered[1])
    return _("Mode: %(modes)s. %(made)s%(of)s.", modes=modes, made=capital(made), of=of)


def _error(summary: Summary) -> str:
    error = summary.metric("fingertip_rmse")
    if error is None or not error.measurable:
        reason = error.status.partition(": ")[2] if error else "it was not measured"
        return _("Fingertip error against the therapist: not measurable (%(reason)s).", reason=remark(reason))
    return _("Fingertip error against the therapist: %(error)s on average.", error=_value(error))


def _dose(summary: Summary) -> list[str]:
    time, by_patient = summary.metric("dose_time"), summary.metric("repetitions_by_patient")
    if time is None or not time.measurable:
        return []
    started = ""
    if by_patient is not None and by_patient.measurable and "passive" not in summary.modes:
        own = round(by_patient.value)
        started = counted(
            ", %(n)s repetition started by the patient", ", %(n)s repetitions started by the patient", own
        )
    return [
        _(
            "In movement %(minutes)s min%(started)s. Support: %(support)s.",
            minutes=decimal(f"{time.value / 60:.1f}"),
            started=started,
            support=remark(summary.conditions or "not recorded"),
        )
    ]


def _ranges(summary: Summary) -> list[str]:
    known = [item for item in summary.named("range_of_motion") if item.measurable and item.value >= LEAST_RAD]
    if not known:
        return [_("Range of motion: not measured, or below 5 degrees.")]
    first = sorted(known, key=lambda item: -item.value)[:MOST_JOINTS]
    most = most_moved(summary)
    source = remark(most.lineage.source) if most is not None else _("an unknown source")
    moved = _(" (the robot moved the hand)") if {"passive", "assistive"} & set(summary.modes) else ""
    ranges = "; ".join(f"{joint_name(item.subject)} {_value(item)}" for item in first)
    return [_("Range by %(source)s%(moved)s: %(ranges)s.", source=source, moved=moved, ranges=ranges)]


def _value(item: Metric) -> str:
    """A number with what must be known of it: its interval, and whether it was only estimated."""
    ends = interval(item)
    unit = unit_shown(item.name, item.unit)
    between = f" (95 %: {ends}{'' if unit == '°' else ' '}{unit})" if ends else ""
    guessed = _(" (estimated)") if "estimated from other joints" in item.status else ""
    return f"{with_unit(item)}{between}{guessed}"
