"""The report of one or more files as blocks: for a patient, for a clinician, then how it was measured."""

from __future__ import annotations

from sessions.metrics import Summary
from sessions.reports.dated import recorded
from sessions.reports.figures import joints_picture, paths_picture, repetitions_picture
from sessions.reports.language import _, decimal, marked
from sessions.reports.letterhead import letterhead
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
from sessions.reports.remarks import remark
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
from sessions.reports.wording import exercise_words, hand

_READING = marked(
    "Small figures: 95 % interval, left out where it is narrower than the last digit; floor: what a "
    "perfectly smooth movement would score with this noise and frame rate. A difference smaller than the "
    "interval is not a change. A dash: not measured or not measurable, for the reason in the note. Flexion "
    "is positive."
)
_NO_PATH = marked("No fingertip path of 5 mm or more was measured, so there is no picture.")


def session_paper(report: Report) -> Paper:
    """A part per file, in the order of the report."""
    parts = tuple(_part(summary, f"s{number}") for number, summary in enumerate(report.summaries))
    header = report.summaries[0].header
    named = " ".join(part for part in (parts[0].title, header.subject_id) if part)
    title = f"{named}: {exercise_words(header.exercise)}"
    return Paper(title, parts, report.software_version)


def _part(summary: Summary, key: str) -> Part:
    title = _("Recorded movement") if summary.header.kind == "take" else _("Therapy session")
    first: tuple[Block, ...] = (Facts(_facts(summary)), Plain(sentences(summary)), _paths(summary, key))
    return Part(title, (*first, Break(), *_clinician(summary, key)))


def _clinician(summary: Summary, key: str) -> tuple[Block, ...]:
    remarks = Remarks()
    overall = overall_table(summary, remarks)
    joints, others = joint_tables(summary, remarks)
    digits, errors = digit_table(summary, remarks), error_table(summary, remarks)
    markers, repetitions = marker_table(summary, remarks), repetition_table(summary)
    blocks: list[Block] = [Heading(_("For the clinician")), Cards(overall.rows), Numbers(joints)]
    if not joints.rows:
        blocks.append(Hint(_("No joint moved by 5 degrees or more."), missing=True))
    blocks += [Numbers(digits), Numbers(errors, "narrow"), Numbers(repetitions)]
    blocks += [Notes(tuple(remarks.texts)), Hint(_reading(summary)), *_charts(summary, key), Break()]
    if markers.rows:
        blocks.append(Numbers(markers, "narrow"))
    elif summary.header.marker_names:
        blocks.append(Hint(_("Every marker was measured in every frame.")))
    return (*blocks, Numbers(others, "small"), *method_blocks(summary))


def _paths(summary: Summary, key: str) -> Picture:
    drawn = paths_picture(summary.overlay, f"{key}p")
    if not drawn:
        return Picture("", _(_NO_PATH))
    caption = _(
        "Fingertip paths seen from the thumb's side, %(shown)s; digits that moved.",
        shown=remark(summary.overlay.shown),
    )
    if summary.overlay.reference is not None:
        at = remark(summary.conditions)
        told = _("Obtained at %(conditions)s.", conditions=at) if at else _("The stiffness is not recorded.")
        lines = _("Patient: blue, solid. Therapist: orange, dashed.")
        caption = f"{caption} {lines} {told}"
    return Picture(drawn, caption, caption)


def _charts(summary: Summary, key: str) -> list[Block]:
    joints = joints_picture(summary, f"{key}j")
    repetitions = repetitions_picture(summary, f"{key}r")
    blocks: list[Block] = []
    if joints or repetitions:
        blocks.append(Heading(_("Charts")))
    if joints:
        caption = _(
            "Angles of the joints that moved most, by %(source)s, %(shown)s.",
            source=sources(summary),
            shown=remark(summary.overlay.shown),
        )
        blocks.append(Picture(joints, caption, caption))
    if repetitions:
        caption = _("By repetition, obtained at %(conditions)s.", conditions=remark(summary.conditions))
        blocks.append(Picture(repetitions, caption, caption))
    return blocks


def _reading(summary: Summary) -> str:
    if summary.header.kind != "therapy":
        return _(_READING)
    told = _(
        "An error against the therapist says something of the patient only together with the stiffness it "
        "was obtained at: %(conditions)s.",
        conditions=remark(summary.conditions) or _("not recorded, so no error is shown"),
    )
    return f"{_(_READING)} {told}"


def _facts(summary: Summary) -> tuple[tuple[str, str], ...]:
    header = summary.header
    whose = _("Recorded hand") if header.kind == "take" else _("Patient")
    lasted = decimal(f"{summary.duration_s:.1f} s")
    facts = [
        *letterhead(),
        (whose, ", ".join((header.subject_id or _("not named"), hand(header.side)))),
        (_("Exercise"), exercise_words(header.exercise)),
        (_("Recorded"), f"{recorded(header)}, {lasted}"),
        (_("Measured by"), sources(summary)),
    ]
    return tuple(facts if header.kind == "take" else [*facts, *_of_therapy(summary)])


def _of_therapy(summary: Summary) -> list[tuple[str, str]]:
    nothing = _("not recorded")
    stops = "; ".join(f"{stop.text or stop.cause} ({decimal(f'{stop.t_s:.1f}')} s)" for stop in summary.stops)
    return [
        (_("Mode"), ", ".join(_(mode) for mode in summary.modes) or nothing),
        (_("Stiffness"), _stiffness(summary) or nothing),
        (_("Stops"), stops or _("none")),
    ]


def _stiffness(summary: Summary) -> str:
    """What held, without the word that stands before it and the mode that stands above it."""
    held = remark(summary.conditions.rpartition(", ")[0] or summary.conditions)
    name = _("stiffness")
    return held.removeprefix(f"{name} ")
