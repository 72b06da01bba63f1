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
from rehab_app.services.kept_numbers import KeptNumbers
from rehab_app.services.outcomes import Outcomes
from rehab_app.services.plans import Plans
from rehab_app.services.population_norms import Norms
from rehab_app.services.presentation import Presentation
from rehab_app.services.progress_assessed import assessed_ranges, assessed_tones, score_of
from rehab_app.services.progress_norms import beside_norms
from rehab_app.services.protocol_records import ProtocolRecords
from rehab_app.services.recompute_work import measured_all
from rehab_app.services.reports import write_whole
from sessions.catalogue import Catalogue, Patient, TherapySession
from sessions.reports import installed_version
from sessions.reports.language import SOURCE
from sessions.reports.letterhead import headed
from sessions.reports.past import Past
from sessions.reports.progress import COMPARISON, LeftOut, Progress
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
        protocols: Results of guided assessments.
        norms: What is usual among the patients of this clinic.
    """

    journal: Journal
    outcomes: Outcomes
    plans: Plans
    protocols: ProtocolRecords
    norms: Norms


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
        self._numbers = KeptNumbers(folder, catalogue)
        self._audit = audit
        self._notebook = notebook
        self._serving = serving
        self._presentation = Presentation(catalogue, audit)

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
        results = self._notebook.protocols.history(patient.id)
        active, passive = assessed_ranges(results, patient.side)
        return Progress(
            patient.id,
            patient.side,
            pasts,
            left_out,
            tuple(score_of(series) for series in self._notebook.outcomes.series(patient.id)),
            tuple((point.utc_ns, point.score) for point in pains),
            self._bounds(),
            self._notebook.plans.current(patient.id).repetitions,
            installed_version(),
            active=active,
            passive=passive,
            tones=assessed_tones(results, patient.side),
            norms=beside_norms(self._notebook.norms, self._catalogue, rows, pasts),
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
            COMPARISON,
        )

    def rendered(self, progress: Progress, format_name: str, language: str = SOURCE) -> bytes:
        """A progress report or comparison in one format of ``PROGRESS_FORMATS``.

        Raises:
            Refused: There is no such format or language.
        """
        if self._serving:
            return aside(_printed, progress, format_name, language, self._presentation.name())
        return _printed(progress, format_name, language, self._presentation.name())

    def download(self, actor: Account, progress: Progress, format_name: str, language: str = SOURCE) -> bytes:
        """As ``rendered``, noted in the audit.

        Raises:
            Refused: The actor may not (verb "view"), or there is no such format.
        """
        require(actor, "view")
        made = self.rendered(progress, format_name, language)
        self._audit.note(actor, "report progress", progress.subject_id, format_name)
        return made

    def write(
        self,
        progress: Progress,
        formats: Sequence[str],
        out: Path | None,
        actor: Account,
        language: str = SOURCE,
    ) -> tuple[Path, ...]:
        """Write one file per format and return their paths.

        Args:
            progress: What is written.
            formats: Names of ``PROGRESS_FORMATS``.
            out: Folder, or file for one format; by default the clinic's reports.
            actor: Who asks (verb "view").
            language: Of the formats that people read.

        Raises:
            Refused: The actor may not, or a format or the language is unknown.
        """
        require(actor, "view")
        contents = [self.rendered(progress, name, language) for name in formats]
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
        works = self._numbers.works(rows)
        found: dict[str, Past | str] = dict(self._numbers.pasts(works))
        missing = [work for work in works if work.sha256 not in found]
        for start in range(0, len(missing), _AT_ONCE):
            part = missing[start : start + _AT_ONCE]
            if say is not None:
                say(f"Measuring sessions {start + 1} to {start + len(part)} of {len(missing)}.")
            answers = aside(measured_all, part) if self._serving else measured_all(part)
            found |= {answer.work.sha256: self._numbers.keep(answer) for answer in answers}
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


def _unfit(past: Past, patient: Patient, row: TherapySession) -> str:
    """Why a session takes no part, empty where it does."""
    if past.sha256 != row.sha256:
        return "its file is not the one that was sealed"
    if past.subject_id != patient.id:
        return f"its file is of {past.subject_id or 'nobody'}, not of {patient.id}"
    if past.side != patient.side:
        return f"of the {past.side} hand"
    return past.reason


def _target(out: Path, stem: str, format_name: str, formats: int) -> Path:
    suffix = PROGRESS_FORMATS[format_name][0]
    return out if formats == 1 and out.name.endswith(suffix) else out / f"{stem}{suffix}"


def _printed(progress: Progress, format_name: str, language: str, clinic: str) -> bytes:
    with headed(clinic):
        return render_progress(progress, format_name, language)
