"""The report of one or more files as blocks: for a patient, for a clinician, then how it was measured."""

from __future__ import annotations

from datetime import UTC, datetime

from sessions.metrics import Summary
from sessions.reports.figures import joints_picture, paths_picture, repetitions_picture
from sessions.reports.method import method_blocks, sources
from sessions.reports.paper import (
    Block,
    Break,
    Cards,
    Facts,
    Heading,
    Hint,
    Notes,
    Numbers,
    Paper,
    Part,
    Picture,
    Plain,
)
from sessions.reports.report import Report
from sessions.reports.sentences import sentences
from sessions.reports.tables import (
    Remarks,
    digit_table,
    error_table,
    joint_tables,
    marker_table,
    overall_table,
    repetition_table,
)

_READING = (
    "Small figures: 95 % interval; floor: what a perfectly smooth movement would score with this noise and "
    "frame rate. A difference smaller than that is not a change. A dash: not measured or not measurable, for "
    "the reason in the note. Flexion is positive."
)
_NO_PATH = "No fingertip path of 5 mm or more was measured, so there is no picture."


def session_paper(report: Report) -> Paper:
    """A part per file, in the order of the report."""
    parts = tuple(_part(summary, f"s{number}") for number, summary in enumerate(report.summaries))
    header = report.summaries[0].header
    title = f"{parts[0].title} {header.subject_id}: {header.exercise}"
    return Paper(title, parts, report.software_version)


def _part(summary: Summary, key: str) -> Part:
    title = "Recorded movement" if summary.header.kind == "take" else "Therapy session"
    first: tuple[Block, ...] = (Facts(_facts(summary)), Plain(sentences(summary)), _paths(summary, key))
    return Part(title, (*first, Break(), *_clinician(summary, key)))


def _clinician(summary: Summary, key: str) -> tuple[Block, ...]:
    remarks = Remarks()
    overall = overall_table(summary, remarks)
    joints, others = joint_tables(summary, remarks)
    digits, errors = digit_table(summary, remarks), error_table(summary, remarks)
    markers, repetitions = marker_table(summary, remarks), repetition_table(summary)
    blocks: list[Block] = [Heading("For the clinician"), Cards(overall.rows), Numbers(joints)]
    if not joints.rows:
        blocks.append(Hint("No joint moved by 5 degrees or more.", missing=True))
    blocks += [Numbers(digits), Numbers(errors, "narrow"), Numbers(repetitions)]
    blocks += [Notes(tuple(remarks.texts)), Hint(_reading(summary)), *_charts(summary, key), Break()]
    if markers.rows:
        blocks.append(Numbers(markers, "narrow"))
    elif summary.header.marker_names:
        blocks.append(Hint("Every marker was measured in every frame."))
    return (*blocks, Numbers(others, "small"), *method_blocks(summary))


def _paths(summary: Summary, key: str) -> Picture:
    drawn = paths_picture(summary.overlay, f"{key}p")
    if not drawn:
        return Picture("", _NO_PATH)
    caption = f"Fingertip paths seen from the thumb's side, {summary.overlay.shown}; digits that moved."
    if summary.overlay.reference is not None:
        at = f"Obtained at {summary.conditions}." if summary.conditions else "The stiffness is not recorded."
        caption += f" Patient: blue, solid. Therapist: orange, dashed. {at}"
    return Picture(drawn, caption, caption)


def _charts(summary: Summary, key: str) -> list[Block]:
    joints = joints_picture(summary, f"{key}j")
    repetitions = repetitions_picture(summary, f"{key}r")
    blocks: list[Block] = []
    if joints or repetitions:
        blocks.append(Heading("Charts"))
    if joints:
        caption = f"Angles of the joints that moved most, by {sources(summary)}, {summary.overlay.shown}."
        blocks.append(Picture(joints, caption, caption))
    if repetitions:
        caption = f"By repetition, obtained at {summary.conditions}."
        blocks.append(Picture(repetitions, caption, caption))
    return blocks


def _reading(summary: Summary) -> str:
    if summary.header.kind != "therapy":
        return _READING
    return (
        f"{_READING} An error against the therapist says something of the patient only together with the "
        f"stiffness it was obtained at: {summary.conditions or 'not recorded, so no error is shown'}."
    )


def _facts(summary: Summary) -> tuple[tuple[str, str], ...]:
    header = summary.header
    started = datetime.fromtimestamp(header.utc_start_ns // 1_000_000_000, tz=UTC)
    whose = "Recorded hand" if header.kind == "take" else "Patient"
    facts = [
        (whose, f"{header.subject_id or 'not named'}, {header.side} hand"),
        ("Exercise", header.exercise or "not named"),
        ("Recorded", f"{started:%d %B %Y, %H:%M} UTC, {summary.duration_s:.1f} s"),
        ("Measured by", sources(summary)),
    ]
    if header.kind == "therapy":
        facts.append(("Mode", ", ".join(summary.modes) or "not recorded"))
        facts.append(("Stiffness used", summary.conditions or "not recorded"))
        stops = "; ".join(f"{stop.text or stop.cause} ({stop.t_s:.1f} s)" for stop in summary.stops)
        facts.append(("Stops", stops or "none"))
    return tuple(facts)
