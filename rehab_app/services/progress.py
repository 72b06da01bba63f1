"""Progress of a patient over all sessions, and the comparison of two: from numbers kept by files' digests."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import msgspec

from rehab_app.access import Account, require
from rehab_app.config import ClinicFolder
from rehab_app.errors import Refused
from rehab_app.services.aside import aside
from rehab_app.services.audit import Audit
from rehab_app.services.journal import Journal
from rehab_app.services.outcome_series import Series
from rehab_app.services.outcomes import Outcomes
from rehab_app.services.plans import Plans
from rehab_app.services.reports import write_whole
from sessions.catalogue import Catalogue, Patient, TherapySession
from sessions.reports import installed_version
from sessions.reports.past import Past, measure_past, past_from_json, past_to_json, past_version
from sessions.reports.progress import LeftOut, Progress, Score
from sessions.reports.progress_formats import PROGRESS_FORMATS, render_progress

_AT_ONCE = 10
"""So many files are measured before their numbers are kept: whoever breaks off goes on from there."""


_REPEATABILITY = "repeatability"
"""Setting that holds what repeated measurements showed, one row per metric and subject."""


@dataclass(frozen=True, slots=True)
class _Detectable:
    """What progress needs of such a row."""

    name: str
    subject: str
    source: str = ""
    mdc95: float | None = None


@dataclass(frozen=True, slots=True)
class Notebook:
    """Where what people wrote of a patient is found.

    Attributes:
        journal: Pain.
        outcomes: The clinic's own scores.
        plans: What is prescribed.
    """

    journal: Journal
    outcomes: Outcomes
    plans: Plans


class ProgressReports:
    """Progress reports.

    Args:
        folder: The clinic folder.
        catalogue: Its catalogue, where numbers are kept.
        audit: Where written reports are noted.
        notebook: What people wrote.
        serving: Whether a server asks: then measuring and rendering happen in a process of their own.
    """

    def __init__(
        self,
        folder: ClinicFolder,
        catalogue: Catalogue,
        audit: Audit,
        notebook: Notebook,
        *,
        serving: bool = False,
    ) -> None:
        self._folder = folder
        self._catalogue = catalogue
        self._audit = audit
        self._notebook = notebook
        self._serving = serving

    def of_patient(self, patient_id: str, say: Callable[[str], None] | None = None) -> Progress:
        """Everything that a progress report starts from.

        Args:
            patient_id: Pseudonym.
            say: Told how far measuring went, where there is something to measure.

        Raises:
            Refused: There is no such patient.
        """
        patient = self._catalogue.patient(patient_id)
        rows = tuple(reversed(self._catalogue.sessions(patient.id)))
        pasts, left_out = self._sorted(patient, rows, self._pasts(rows, say))
        pains = self._notebook.journal.pain_course(patient.id)
        return Progress(
            patient.id,
            patient.side,
            pasts,
            left_out,
            tuple(_score(series) for series in self._notebook.outcomes.series(patient.id)),
            tuple((point.utc_ns, point.score) for point in pains),
            self._bounds(),
            self._notebook.plans.current(patient.id).repetitions,
            installed_version(),
        )

    def comparison(self, first: str, second: str) -> Progress:
        """Two sessions of one patient, the earlier one first.

        Args:
            first: Catalogue id of a session.
            second: Catalogue id of another.

        Raises:
            Refused: They are one session, of two patients, of no patient, or cannot be measured.
        """
        rows = sorted(
            (self._catalogue.session(first), self._catalogue.session(second)),
            key=lambda row: row.started_utc_ns,
        )
        one, other = rows
        if one.id == other.id:
            raise Refused(
                "comparison", f"of session {one.id} with itself", "of two sessions", "choose another"
            )
        if one.patient != other.patient or not one.patient:
            value = "of two patients" if one.patient or other.patient else "of sessions without a patient"
            raise Refused("comparison", value, "of two sessions of one patient", "choose another")
        patient = self._catalogue.patient(one.patient)
        pasts, left_out = self._sorted(patient, rows, self._pasts(rows, None))
        if left_out:
            raise Refused(
                f"session {left_out[0].session_id}", left_out[0].reason, "one with numbers", "choose another"
            )
        return Progress(
            patient.id,
            patient.side,
            pasts,
            (),
            (),
            (),
            self._bounds(),
            0,
            installed_version(),
            "Comparison of two sessions",
        )

    def rendered(self, progress: Progress, format_name: str) -> bytes:
        """A progress report or comparison in one format of ``PROGRESS_FORMATS``.

        Raises:
            Refused: There is no such format.
        """
        if self._serving:
            return aside(render_progress, progress, format_name)
        return render_progress(progress, format_name)

    def download(self, actor: Account, progress: Progress, format_name: str) -> bytes:
        """As ``rendered``, noted in the audit.

        Raises:
            Refused: The actor may not (verb "view"), or there is no such format.
        """
        require(actor, "view")
        made = self.rendered(progress, format_name)
        self._audit.note(actor, "report progress", progress.subject_id, format_name)
        return made

    def write(
        self, progress: Progress, formats: Sequence[str], out: Path | None, actor: Account
    ) -> tuple[Path, ...]:
        """Write one file per format and return their paths.

        Args:
            progress: What is written.
            formats: Names of ``PROGRESS_FORMATS``.
            out: Folder, or file for one format; by default the clinic's reports.
            actor: Who asks (verb "view").

        Raises:
            Refused: The actor may not, or a format is unknown.
        """
        require(actor, "view")
        contents = [self.rendered(progress, name) for name in formats]
        stem = f"{progress.title.split(' ', maxsplit=1)[0].lower()}-{progress.subject_id}"
        targets = [_target(out or self._folder.reports, stem, name, len(formats)) for name in formats]
        for target, content in zip(targets, contents, strict=True):
            write_whole(target, content)
        self._audit.note(actor, "report progress", progress.subject_id)
        return tuple(targets)

    def _bounds(self) -> tuple[tuple[str, str, str, float], ...]:
        """Minimal detectable changes of this set-up; empty where nobody measured its repeatability."""
        kept = self._catalogue.setting(_REPEATABILITY)
        rows = () if kept is None else msgspec.json.decode(kept.content, type=tuple[_Detectable, ...])
        return tuple((row.name, row.subject, row.source, row.mdc95) for row in rows if row.mdc95 is not None)

    def _pasts(
        self, rows: Sequence[TherapySession], say: Callable[[str], None] | None
    ) -> dict[str, Past | str]:
        """What is known of each file by its digest: its numbers, or why there are none."""
        version = past_version()
        kept = self._catalogue.kept_metrics([row.sha256 for row in rows], version)
        found: dict[str, Past | str] = {digest: past_from_json(text) for digest, text in kept.items()}
        missing = [row for row in rows if row.sha256 not in found]
        for start in range(0, len(missing), _AT_ONCE):
            part = missing[start : start + _AT_ONCE]
            if say is not None:
                say(f"Measuring sessions {start + 1} to {start + len(part)} of {len(missing)}.")
            paths = [self._folder.root / row.path for row in part]
            measured = aside(_measured, paths) if self._serving else _measured(paths)
            for row, answer in zip(part, measured, strict=True):
                found[row.sha256] = answer
                if isinstance(answer, Past) and answer.sha256 == row.sha256:
                    self._catalogue.keep_metrics(row.sha256, version, past_to_json(answer))
        return found

    def _sorted(
        self, patient: Patient, rows: Sequence[TherapySession], found: dict[str, Past | str]
    ) -> tuple[tuple[Past, ...], tuple[LeftOut, ...]]:
        pasts, left_out = list[Past](), list[LeftOut]()
        for row in rows:
            past = found[row.sha256]
            reason = past if isinstance(past, str) else _unfit(past, patient, row)
            if isinstance(past, Past) and not reason:
                pasts.append(replace(past, session_id=row.id))
            else:
                left_out.append(LeftOut(row.id, row.started_utc_ns, reason))
        return tuple(pasts), tuple(left_out)


def _measured(paths: Sequence[Path]) -> list[Past | str]:
    """The past of each file, or why it cannot be read."""
    answers: list[Past | str] = []
    for path in paths:
        try:
            answers.append(measure_past(path))
        except Refused as refusal:
            answers.append(str(refusal))
    return answers


def _unfit(past: Past, patient: Patient, row: TherapySession) -> str:
    """Why a session takes no part, empty where it does."""
    if past.sha256 != row.sha256:
        return "its file is not the one that was sealed"
    if past.subject_id != patient.id:
        return f"its file is of {past.subject_id or 'nobody'}, not of {patient.id}"
    if past.side != patient.side:
        return f"of the {past.side} hand"
    return past.reason


def _score(series: Series) -> Score:
    chosen = series.measure
    unit = f" ({chosen.shown})" if chosen.shown else ""
    name = ", ".join(part for part in (chosen.words, series.side, series.place) if part) + unit
    change = "—" if series.change is None else f"{round(series.change / chosen.per_shown, 2):+g}"
    return Score(
        name,
        chosen.text(series.baseline.value),
        "—" if series.last is None else chosen.text(series.last.value),
        chosen.text(series.now.value),
        change,
        _meaning(series),
    )


def _meaning(series: Series) -> str:
    """The change beside the published one that matters to patients."""
    if series.change is None:
        return "measured once"
    if series.measure.mcid is None:
        return f"{series.direction}; no important difference is published"
    low, high = (round(end / series.measure.per_shown, 2) for end in series.measure.mcid)
    published = series.measure.mcid_words or (f"{low:g}" if low == high else f"{low:g} to {high:g}")
    return f"{series.direction}, {series.meaning} (published: {published})"


def _target(out: Path, stem: str, format_name: str, formats: int) -> Path:
    suffix = PROGRESS_FORMATS[format_name][0]
    return out if formats == 1 and out.name.endswith(suffix) else out / f"{stem}{suffix}"
