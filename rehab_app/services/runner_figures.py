"""The few figures of a sealed session that a note holds; measured in a process of its own while serving."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from rehab_app.errors import REFUSALS
from rehab_app.services.aside import aside
from rehab_app.services.rows import SessionRow
from rehab_app.services.sweep_postures import FIT, RANGE
from sessions.metrics import Summary, measure_file

_TITLES = {RANGE: "Range measured", FIT: "Fit check", "open_close": "Hand opening and closing"}
_MOST_STOPS = 6


@dataclass(frozen=True, slots=True, kw_only=True)
class RunFigures:
    """Figures of one run.

    Attributes:
        title: What it was.
        mode: Therapy mode, as in files.
        guided: Whether it was a guided assessment rather than therapy.
        repetitions: How many were begun.
        completed: How many were moved to their end.
        prescribed: How many were asked for, 0 where that is unknown.
        by_patient: How many the patient started.
        moved_s: Time spent moving and holding, s.
        error_m: RMS fingertip error, m; NaN where nothing was compared.
        ranges: Range by digit in words, of assessments.
        changes: What was changed on the way, in words.
        stops: Interruptions in words.
    """

    title: str
    mode: str = ""
    guided: bool = False
    repetitions: int = 0
    completed: int = 0
    prescribed: int = 0
    by_patient: int = 0
    moved_s: float = 0.0
    error_m: float = math.nan
    ranges: tuple[str, ...] = ()
    changes: str = ""
    stops: tuple[str, ...] = ()


def figures_of(rows: tuple[tuple[Path, str], ...]) -> tuple[RunFigures, ...]:
    """Figures of files; one that cannot be measured is named and left without figures.

    Args:
        rows: Path and mode of each session, oldest first.
    """
    found: list[RunFigures] = []
    for path, mode in rows:
        try:
            found.append(_figures(measure_file(path), mode))
        except REFUSALS as refusal:
            found.append(RunFigures(title=f"A run without figures ({refusal.thing} is {refusal.value})"))
    return tuple(found)


def note_figures(*, serving: bool) -> Callable[[tuple[SessionRow, ...]], tuple[RunFigures, ...]]:
    """What measures rows of the catalogue, oldest first.

    Args:
        serving: Whether a server asks: then they are measured in a process of their own.
    """

    def measured(rows: tuple[SessionRow, ...]) -> tuple[RunFigures, ...]:
        asked = tuple((row.path, row.mode) for row in rows)
        if not asked:
            return ()
        return aside(figures_of, asked) if serving else figures_of(asked)

    return measured


def _figures(summary: Summary, mode: str) -> RunFigures:
    exercise = summary.header.exercise
    guided = exercise in (RANGE, FIT)
    return RunFigures(
        title=_TITLES.get(exercise, exercise.replace("_", " ").capitalize() or "Exercise"),
        mode=mode,
        guided=guided,
        repetitions=len(summary.repetitions),
        completed=sum(one.completed for one in summary.repetitions),
        prescribed=_prescribed(summary.header.prescription),
        by_patient=sum(one.started_by == "patient" for one in summary.repetitions),
        moved_s=0.0 if guided else _value(summary, "dose_time", 0.0),
        error_m=math.nan if guided else _value(summary, "fingertip_rmse", math.nan),
        ranges=_ranges(summary) if exercise == RANGE else (),
        changes=_changes(summary),
        stops=tuple((stop.text or stop.cause).rstrip(".") for stop in summary.stops[:_MOST_STOPS]),
    )


def _prescribed(text: str) -> int:
    try:
        found = json.loads(text).get("repetitions", 0)
    except (ValueError, AttributeError):
        return 0
    return found if isinstance(found, int) else 0


def _value(summary: Summary, name: str, otherwise: float) -> float:
    found = summary.metric(name)
    return found.value if found is not None and found.measurable else otherwise


def _ranges(summary: Summary) -> tuple[str, ...]:
    """Smallest to largest angle by joint of the fingers' MCP and PIP, in degrees."""
    smallest = {one.subject: one.value for one in summary.named("angle_min")}
    words: list[str] = []
    for one in summary.named("angle_max"):
        low, high = smallest.get(one.subject, math.nan), one.value
        if not (math.isfinite(low) and math.isfinite(high)):
            continue
        if one.subject.endswith(("_mcp_flexion", "_pip")):
            joint = one.subject.removesuffix("_flexion").replace("_", " ").replace("mcp", "MCP")
            words.append(
                f"{joint.replace('pip', 'PIP')} {math.degrees(low):.0f} to {math.degrees(high):.0f}°"
            )
    return tuple(words)


def _changes(summary: Summary) -> str:
    """How support went from the first to the last repetition, where it changed."""
    known = [one for one in summary.repetitions if one.assistance]
    if len(known) < 2:
        return ""
    first, last = (sum(one.assistance) / len(one.assistance) for one in (known[0], known[-1]))
    if not (math.isfinite(first) and math.isfinite(last)) or abs(first - last) < 0.05:
        return ""
    return f"support ×{first:.1f} to ×{last:.1f}"
