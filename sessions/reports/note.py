"""A short note in plain text, to be pasted into the clinic's own record."""

from __future__ import annotations

from datetime import UTC, datetime

from sessions.metrics import Metric, Summary
from sessions.reports.report import Report
from sessions.reports.sentences import most_moved, sentences
from sessions.reports.wording import interval, joint_name, unit_shown, with_unit

MOST_JOINTS = 4
LEAST_RAD = 0.0873
"""5 degrees: joints that moved less do not stand in a note."""


def render_note(report: Report) -> str:
    """At most a dozen short lines per file: what was done, how far it went, what must be known beside it."""
    return "\n\n".join(_note(summary) for summary in report.summaries) + "\n"


def _note(summary: Summary) -> str:
    header = summary.header
    started = datetime.fromtimestamp(header.utc_start_ns // 1_000_000_000, tz=UTC)
    kind = "Recorded movement" if header.kind == "take" else "Robot-assisted hand therapy"
    lines = [
        f"{kind}, {started:%d %b %Y %H:%M} UTC. {header.subject_id or 'Hand not named'}, {header.side} hand. "
        f"{header.exercise or 'Exercise not named'}.",
        *sentences(summary)[:2],
        *_dose(summary),
        *_ranges(summary),
        *(f"Stop at {stop.t_s:.0f} s: {stop.text or stop.cause}" for stop in summary.stops),
        f"Not a certified medical device. File {summary.sha256[:12]}.",
    ]
    return "\n".join(lines)


def _dose(summary: Summary) -> list[str]:
    time, by_patient = summary.metric("dose_time"), summary.metric("repetitions_by_patient")
    if time is None or not time.measurable:
        return []
    started = (
        f", {by_patient.value:.0f} started by the patient" if by_patient and by_patient.measurable else ""
    )
    minutes = f"{time.value / 60:.1f} min"
    return [f"In movement {minutes}{started}. Support: {summary.conditions or 'not recorded'}."]


def _ranges(summary: Summary) -> list[str]:
    known = [item for item in summary.named("range_of_motion") if item.measurable and item.value >= LEAST_RAD]
    if not known:
        return ["Range of motion: not measured."]
    first = sorted(known, key=lambda item: -item.value)[:MOST_JOINTS]
    most = most_moved(summary)
    source = most.lineage.source if most is not None else "an unknown source"
    moved = " (the robot moved the hand)" if {"passive", "assistive"} & set(summary.modes) else ""
    return [f"Range by {source}{moved}: " + "; ".join(_range(item) for item in first) + "."]


def _range(item: Metric) -> str:
    ends = interval(item)
    between = f" (95 % {ends}{unit_shown(item.name, item.unit)})" if ends else ""
    return f"{joint_name(item.subject)} {with_unit(item)}{between}"
