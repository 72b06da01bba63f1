"""The clinician's table of progress: baseline, last, now, the change and its verdict, by joint and side."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field, replace

from sessions.metrics import definition
from sessions.records import DIGITS, JOINTS
from sessions.reports.assessed import BY_JOINT as ASSESSED
from sessions.reports.language import _, counted, decimal
from sessions.reports.paper import Words
from sessions.reports.past import Kept, Past
from sessions.reports.progress import Line, Progress, line, moved_joints
from sessions.reports.remarks import remark
from sessions.reports.tables import Cell, Row, Table, heading
from sessions.reports.verdict import ERRORS, STRETCH_RAD, helped, stiffness_of
from sessions.reports.wording import (
    MISSING,
    capital,
    hand,
    mode_words,
    number,
    span,
    subject_name,
    unit_shown,
)

BY_JOINT = ("range_of_motion", "angle_max", "angle_min")
BY_DIGIT = ("fingertip_rmse", "total_active_motion", "sparc", "movement_time")
OVERALL = ("repetitions", "repetitions_by_patient", "dose_time", "dose_completed", "robot_share", "stops")
ALL_NAMES = (*BY_JOINT, *BY_DIGIT, *OVERALL, "joint_rmse", "stiffness")


@dataclass(slots=True)
class Judgements:
    """Numbered reasons, while tables are made; the same words get the same number."""

    texts: list[str] = field(default_factory=list[str])

    def of(self, text: str) -> int:
        """Number of a text, 0 for an empty one."""
        if not text:
            return 0
        sentence = f"{capital(text)}."
        if sentence not in self.texts:
            self.texts.append(sentence)
        return self.texts.index(sentence) + 1


def judged_tables(progress: Progress, judgements: Judgements) -> tuple[Table, ...]:
    """One table per metric and mode that some session has: modes are never compared with each other."""
    wanted: list[tuple[str, Iterable[str]]] = [(name, moved_joints(progress.pasts)) for name in BY_JOINT]
    wanted += [("joint_rmse", ("whole",)), *((name, (*DIGITS, "whole")) for name in BY_DIGIT)]
    views = _by_mode(progress)
    made = (
        _table(view, name, subjects, judgements, mode) for name, subjects in wanted for view, mode in views
    )
    return tuple(table for table in made if table.rows)


def _by_mode(progress: Progress) -> list[tuple[Progress, str]]:
    """The sessions of each mode, that of the latest session first; all together where two are compared."""
    modes = [past.modes for past in reversed(progress.pasts)]
    if len(progress.pasts) <= 2 or len({frozenset(one) for one in modes}) < 2:
        return [(progress, "")]
    return [
        (
            replace(progress, pasts=tuple(one for one in progress.pasts if frozenset(one.modes) == of_mode)),
            _("%(modes)s mode", modes=mode_words(sorted(of_mode))),
        )
        for of_mode in dict.fromkeys(frozenset(one) for one in modes)
    ]


def assessed_tables(progress: Progress, judgements: Judgements) -> tuple[Table, ...]:
    """Active and passive range, share of the norm, lag and deficit by joint, from the range assessments."""
    made: list[Table] = []
    for pasts in (progress.active, progress.passive):
        view = replace(progress, pasts=pasts)
        joints = [joint for joint in JOINTS if any(past.number("range_of_motion", joint) for past in pasts)]
        made += [_table(view, name, joints, judgements) for name in ASSESSED]
    return tuple(table for table in made if table.rows)


def overall_words(progress: Progress) -> Words:
    """Dose and support in the first session, the one before the latest, and the latest; sums over all."""
    pasts = progress.pasts
    two = len(pasts) == 2
    shown = [
        past for past in (pasts[:1], pasts[-2:-1] if len(pasts) > 2 else (), pasts[1:][-1:]) for past in past
    ]
    names = (
        (_("First"), _("Second"))
        if two
        else (_("First"), _("Last"), _("Now"))
        if len(shown) == 3
        else (_("Now"),)
    )
    rows = [(heading(name), *(_plain(name, past) for past in shown)) for name in OVERALL if _any(pasts, name)]
    stiffness = tuple(
        MISSING if math.isnan(value := stiffness_of(past)) else decimal(f"{value:.2f}") for past in shown
    )
    rows.append((heading("stiffness"), *stiffness))
    return Words((_("Dose and support"), *names), tuple(rows))


def _table(
    progress: Progress, name: str, subjects: Iterable[str], judgements: Judgements, mode: str = ""
) -> Table:
    lines = [found for subject in subjects if (found := line(progress, name, subject)) is not None]
    two = not mode and len(progress.pasts) <= 2
    shown = (_("First"), _("Second")) if two else (_("Baseline"), _("Last"), _("Now"))
    columns = ("", *shown, _("Change"), _("MDC"), _("Verdict"))
    rows = tuple(_row(item, two, judgements) for item in lines)
    title = _title(progress, name, lines, bool(mode))
    return Table(f"{title}, {mode}" if mode else title, columns, rows)


def _title(progress: Progress, name: str, lines: list[Line], moded: bool) -> str:
    """Metric, unit and side; of an angle also what measured it and who moved, of an error the stiffness."""
    parts = [heading(name), hand(progress.side)]
    if lines and name in (*BY_JOINT, *ASSESSED, "total_active_motion"):
        sources = _(" and ").join(dict.fromkeys(remark(item.now.source) for item in lines))
        parts += [_("by %(sources)s", sources=sources)]
        parts.append(_("the robot moved the hand") if helped(lines[0].session) else _("the patient moved"))
    if lines and name in (*ERRORS, "sparc", "movement_time"):
        held = lines[0].session.conditions
        at = remark(held.rpartition(", ")[0] if moded else held) or _("unknown stiffness")
        parts.append(_("now at %(stiffness)s", stiffness=at))
    return ", ".join(parts)


def _row(item: Line, two: bool, judgements: Judgements) -> Row:
    shown = [_cell(item, item.baseline), *([] if two else [_cell(item, item.last)]), _cell(item, item.now)]
    flag = judgements.of(remark(item.now.status.partition(": ")[2]))
    shown[-1] = Cell(shown[-1].text, shown[-1].interval, flag)
    change = item.change
    difference = MISSING if math.isnan(change.difference) else signed(item, change.difference)
    bound = MISSING if math.isnan(change.bound) else number(item.name, item.unit, change.bound)
    verdict = Cell(_(change.verdict), "", judgements.of(_why(item)))
    return Row(subject_name(item.subject), (*shown, Cell(difference), Cell(bound), verdict))


def _why(item: Line) -> str:
    count, reason = item.others
    texts = [item.change.why] if item.change.why and item.change.why != reason else []
    if count:
        texts.append(
            counted(
                "%(n)s earlier session not compared (%(why)s)",
                "%(n)s earlier sessions not compared (%(why)s)",
                count,
                why=reason,
            )
        )
    gain = item.unit == "rad" and item.name not in ERRORS and item.change.verdict == "real"
    if gain and abs(item.change.difference) <= STRETCH_RAD:
        texts.append(_("no more than stretching alone gains"))
    return "; ".join(texts)


def signed(item: Line, difference: float) -> str:
    """A difference with its sign."""
    text = number(item.name, item.unit, difference)
    return text if text.startswith("-") else f"+{text}"


def _cell(item: Line, found: Kept | None) -> Cell:
    if found is None or found.value is None:
        return Cell(MISSING)
    ends = ""
    if found.low is not None and found.high is not None:
        low, high = (number(item.name, item.unit, end) for end in (found.low, found.high))
        ends = "" if low == high == number(item.name, item.unit, found.value) else span(low, high)
    return Cell(number(item.name, item.unit, found.value), ends)


def _plain(name: str, past: Past) -> str:
    return number(name, definition(name).unit, past.value(name))


def _any(pasts: Iterable[Past], name: str) -> bool:
    return any(not math.isnan(past.value(name)) for past in pasts)


def shown_unit(name: str) -> str:
    """Unit that a person reads for a metric."""
    return unit_shown(name, definition(name).unit)
