"""The note of a session: plain text that a clinician pastes into the clinic's own record."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from rehab_app.services.clock import local_day
from rehab_app.services.journal import CheckIn, Entry, Journal, PainReport
from rehab_app.services.rows import SessionRow
from rehab_app.services.runner_figures import RunFigures
from rehab_app.services.runner_steps import STEPS, Course
from rehab_app.services.sessions import Sessions
from sessions.catalogue import Catalogue
from sessions.reports.wording import MODES

_NOT_SAID = "not asked"
_MODES = {**MODES, "passive": "passive (CPM)"}


@dataclass(frozen=True, slots=True)
class Told:
    """A note.

    Attributes:
        heading: Date and patient as the screen shows them; for the clipboard only, never for files.
        text: Everything else.
    """

    heading: str
    text: str

    @property
    def whole(self) -> str:
        """Both, as they are copied."""
        return f"{self.heading}\n{self.text}"


class Notes:
    """Composes notes.

    Args:
        catalogue: Patients.
        journal: Check-in and pain.
        sessions: What was run.
        figures: Figures of sealed sessions, in the order of the rows.
    """

    def __init__(
        self,
        catalogue: Catalogue,
        journal: Journal,
        sessions: Sessions,
        figures: Callable[[tuple[SessionRow, ...]], tuple[RunFigures, ...]],
    ) -> None:
        self._catalogue = catalogue
        self._journal = journal
        self._sessions = sessions
        self._figures = figures

    def sessions(self, course: Course) -> tuple[SessionRow, ...]:
        """What was run in the session, newest first."""
        rows = self._sessions.list(course.patient)
        return tuple(row for row in rows if row.started_utc_ns >= course.began_utc_ns)

    def compose(self, course: Course, now_utc_ns: int) -> Told:
        """The note of a session so far.

        Raises:
            Refused: The patient is unknown, or a sealed session is damaged.
        """
        patient = self._catalogue.patient(course.patient)
        minutes = max(round((now_utc_ns - course.began_utc_ns) / 60e9), 1)
        name = f"{patient.given_name} {patient.family_name}".strip() or patient.id
        day = local_day(course.began_utc_ns).isoformat()
        heading = f"{day}  {name}, born {patient.birth_date or 'not noted'}, {patient.side.upper()} hand"
        entries = {one.id: one for one in self._journal.entries(course.patient, ("check-in", "pain"))}
        runs = self._figures(tuple(reversed(self.sessions(course))))
        lines = [
            f"Robot-assisted hand therapy, {minutes} min, led by {course.by}.",
            *_check_in(entries.get(course.check_in)),
            _pain(course, entries),
            *_done(runs),
            *_left_out(course),
        ]
        return Told(heading, "\n".join(line for line in lines if line))


def _check_in(entry: Entry | None) -> list[str]:
    if entry is None or not isinstance(entry.what, CheckIn):
        return ["Check-in: not done."]
    said = entry.what
    parts = [f"skin {said.skin or _NOT_SAID}", f"swelling {said.swelling or _NOT_SAID}"]
    if said.botulinum_date:
        parts.append(f"botulinum {said.botulinum_date}")
    if said.precautions:
        parts.append("precautions: " + " ".join(said.precautions.split()))
    if said.remark:
        parts.append(" ".join(said.remark.split()))
    return ["Check-in: " + "; ".join(parts) + "."]


def _pain(course: Course, entries: dict[int, Entry]) -> str:
    """Pain before, during and after: the check-in's first, then every tap by the time it was felt."""
    said: dict[str, list[str]] = {"before": [], "during": [], "after": []}
    first = entries.get(course.check_in)
    if first is not None and isinstance(first.what, CheckIn) and first.what.pain is not None:
        said["before"].append(f"{first.what.pain}/10")
    for number in course.pains:
        entry = entries.get(number)
        if entry is not None and isinstance(entry.what, PainReport):
            said.setdefault(entry.what.when, []).append(_one_pain(entry.what))
    words = [f"{when} {', '.join(said[when]) or 'none entered'}" for when in ("before", "during", "after")]
    return "Pain: " + "; ".join(words) + "."


def _one_pain(report: PainReport) -> str:
    score = "no score" if report.score is None else f"{report.score}/10"
    return f"{score} ({report.place})" if report.place else score


def _done(runs: tuple[RunFigures, ...]) -> list[str]:
    if not runs:
        return ["Nothing was run on the robot."]
    lines = ["Done:", *("- " + _run(run) for run in runs)]
    completed = sum(run.completed for run in runs)
    active = sum(run.by_patient for run in runs)
    moved_min = sum(run.moved_s for run in runs) / 60.0
    lines.append(
        f"Dose: {completed} repetitions, {active} started by the patient, {moved_min:.1f} min moved."
    )
    stops = [stop for run in runs for stop in run.stops]
    lines.append("Stops: " + ("; ".join(stops) if stops else "none") + ".")
    return lines


def _run(run: RunFigures) -> str:
    parts = [run.title if not run.mode or run.guided else f"{run.title}, {_MODES.get(run.mode, run.mode)}"]
    if not run.guided:
        parts.append(f"{run.completed} of {run.prescribed or run.repetitions} repetitions")
    if math.isfinite(run.error_m):
        parts.append(f"error {1e3 * run.error_m:.1f} mm RMS")
    if run.ranges:
        parts.append("range " + ", ".join(run.ranges))
    if run.changes:
        parts.append(run.changes)
    return "; ".join(parts) + "."


def _left_out(course: Course) -> list[str]:
    """Steps that were not done, with the reasons that were given."""
    words: list[str] = []
    for step in STEPS[:-1]:
        if course.state_of(step.key) != "skipped":
            continue
        why = next((one.reason for one in reversed(course.stays) if one.step == step.key and one.reason), "")
        words.append(f"{step.words} ({why})" if why else step.words)
    return ["Left out: " + ", ".join(words) + "."] if words else []
