"""The clinician's tables: cells with unit, interval and a numbered note wherever something must be said."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

from sessions.metrics import Metric, Summary, definition
from sessions.records import DIGITS, JOINTS
from sessions.reports.language import _, counted, marked
from sessions.reports.remarks import remark
from sessions.reports.wording import MISSING, capital, interval, number, span, subject_name, unit_shown

MOVED_RAD = 0.0873
"""5 degrees: joints that moved less stand in the appendix."""
BY_JOINT = ("range_of_motion", "angle_min", "angle_max", "joint_rmse", "stiffness", "interaction_torque")
BY_DIGIT = (
    "fingertip_rmse",
    "sparc",
    "ldlj",
    "movement_time",
    "peak_speed",
    "path_ratio",
    "assistance",
    "robot_share",
    "total_active_motion",
)
OF_THE_ERROR = ("timing_delay", "timing_warp", "shape_error", "offset_error")
OVERALL = (
    "repetitions",
    "repetitions_by_patient",
    "repetition_rate",
    "dose_time",
    "dose_completed",
    "stops",
    "joint_rmse",
    "fingertip_rmse",
    "robot_share",
    "robot_work",
    "returned_work",
    "fit_residual",
)
BY_MARKER = ("valid_share", "longest_gap")
_STARTED = {"robot": marked("robot"), "patient": marked("patient")}


@dataclass(frozen=True, slots=True)
class Cell:
    """One number of a table.

    Attributes:
        text: The number, or a dash.
        interval: Its 95 % interval, empty where there is none.
        note: Number of the note below the table, 0 where nothing need be said.
        floor: What a perfectly smooth movement would score, empty for other numbers.
    """

    text: str
    interval: str = ""
    note: int = 0
    floor: str = ""


@dataclass(frozen=True, slots=True)
class Row:
    """One joint, digit or number."""

    name: str
    cells: tuple[Cell, ...]


@dataclass(frozen=True, slots=True)
class Table:
    """One table.

    Attributes:
        title: Heading.
        columns: Column headings, unit included.
        rows: Rows.
    """

    title: str
    columns: tuple[str, ...]
    rows: tuple[Row, ...]


@dataclass(slots=True)
class Remarks:
    """Numbered remarks, while a page is written; the same words get the same number."""

    texts: list[str] = field(default_factory=list[str])

    def of(self, item: Metric) -> int:
        """Number of a metric's remark, 0 where its status is "ok"."""
        if item.status == "ok":
            return 0
        kind, _colon, said = item.status.partition(": ")
        words = remark(said)
        text = (
            _("Not measurable: %(reason)s.", reason=words)
            if kind == "not measurable"
            else f"{capital(words)}."
        )
        if text not in self.texts:
            self.texts.append(text)
        return self.texts.index(text) + 1


def joint_tables(summary: Summary, notes: Remarks) -> tuple[Table, Table]:
    """Joints that moved or were driven, and the other joints."""
    found = {item.subject: item for item in summary.named("range_of_motion")}
    driven = set(summary.header.robot_joints)
    first = [
        joint
        for joint in JOINTS
        if joint in driven or (joint in found and found[joint].measurable and found[joint].value >= MOVED_RAD)
    ]
    others = [joint for joint in JOINTS if joint not in first]
    return (
        _by_subject(_("Joints"), summary, BY_JOINT, first, notes),
        _by_subject(_("Other joints"), summary, BY_JOINT, others, notes),
    )


def digit_table(summary: Summary, notes: Remarks) -> Table:
    """Digits as columns would not fit a page: one row per digit."""
    return _by_subject(_("Fingertips"), summary, BY_DIGIT, DIGITS, notes)


def error_table(summary: Summary, notes: Remarks) -> Table:
    """What the fingertips' error against the therapist is made of; without rows for a take."""
    there = any(summary.named(name) for name in OF_THE_ERROR)
    return _by_subject(_("Error taken apart"), summary, OF_THE_ERROR, DIGITS if there else (), notes)


def marker_table(summary: Summary, notes: Remarks) -> Table:
    """Markers that were not seen all the time; without rows where all were, or the file has none."""
    gaps = [item.subject for item in summary.named("valid_share") if not item.value >= 1.0]
    rest = len(summary.named("valid_share")) - len(gaps)
    title = _("Markers with gaps")
    if rest:
        title += counted(
            " (%(n)s other was measured in every frame)", " (%(n)s others were measured in every frame)", rest
        )
    return _by_subject(title, summary, BY_MARKER, gaps, notes)


def overall_table(summary: Summary, notes: Remarks) -> Table:
    """Numbers of the whole file."""
    rows: list[Row] = []
    for name in OVERALL:
        item = summary.metric(name)
        if item is not None:
            rows.append(Row(heading(name), (_cell(item, notes, summary),)))
    return Table(_("Overall"), ("", _("Value")), tuple(rows))


def repetition_table(summary: Summary) -> Table:
    """One row per repetition; without rows for a take."""
    columns = (
        _("Repetition"),
        _("Started by"),
        _("Completed"),
        heading("joint_rmse"),
        heading("fingertip_rmse"),
        _("Assistance (× thesis gains)"),
        heading("robot_share"),
    )
    rows: list[Row] = []
    for item in summary.repetitions:
        helped = sorted(value for value in item.assistance if value == value)
        ends = [number("assistance", "1", value) for value in (helped[:1] + helped[-1:])]
        texts = (
            _(_STARTED.get(item.started_by, item.started_by)) or MISSING,
            _("yes") if item.completed else _("no"),
            number("joint_rmse", "rad", item.rmse_rad),
            number("fingertip_rmse", "m", item.fingertip_rmse_m),
            span(*ends) if ends else MISSING,
            number("robot_share", "1", item.robot_share),
        )
        rows.append(Row(str(item.index + 1), tuple(Cell(text) for text in texts)))
    return Table(_("Repetitions"), columns, tuple(rows))


def heading(name: str) -> str:
    """Title and unit of a metric."""
    known = definition(name)
    unit = unit_shown(name, known.unit)
    return f"{_(known.title)} ({unit})" if unit else _(known.title)


def _by_subject(
    title: str, summary: Summary, names: Iterable[str], subjects: Iterable[str], notes: Remarks
) -> Table:
    """Subjects down, metrics across; metrics that the file does not have at all are left out."""
    chosen = [name for name in names if any(item.subject != "whole" for item in summary.named(name))]
    rows: list[Row] = []
    for subject in subjects:
        found = [summary.metric(name, subject) for name in chosen]
        cells = tuple(Cell(MISSING) if item is None else _cell(item, notes, summary) for item in found)
        rows.append(Row(subject_name(subject), cells))
    return Table(title, ("", *(heading(name) for name in chosen)), tuple(rows))


def _cell(item: Metric, notes: Remarks, summary: Summary) -> Cell:
    floor = summary.metric(f"{item.name}_floor", item.subject)
    lowest = number(floor.name, floor.unit, floor.value) if floor and floor.measurable else ""
    return Cell(number(item.name, item.unit, item.value), interval(item), notes.of(item), lowest)
