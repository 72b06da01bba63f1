"""Reports of takes and sessions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from rehab_app.access import Account, require
from rehab_app.config import ClinicFolder
from rehab_app.errors import Refused
from rehab_app.services.aside import aside
from rehab_app.services.audit import Audit
from rehab_app.services.passive_runs import passive_runs
from rehab_app.services.presentation import Presentation
from rehab_app.services.sessions import Sessions
from sessions.catalogue import Catalogue
from sessions.reports import FORMATS, Format, Report, build_report
from sessions.reports.language import SOURCE
from sessions.reports.letterhead import headed


class Reports:
    """Reports; a subject is a path or the catalogue id of a session or take.

    Args:
        folder: The clinic folder.
        catalogue: Its catalogue, where the day's passive runs are found.
        sessions: Where subjects are found.
        audit: Where written reports are noted.
        serving: Whether a server asks: then each report is measured and rendered in a process of its own.
    """

    def __init__(
        self,
        folder: ClinicFolder,
        catalogue: Catalogue,
        sessions: Sessions,
        audit: Audit,
        *,
        serving: bool = False,
    ) -> None:
        self._folder = folder
        self._catalogue = catalogue
        self._sessions = sessions
        self._audit = audit
        self._serving = serving
        self._presentation = Presentation(catalogue, audit)

    def report(
        self,
        subjects: Sequence[str | Path],
        formats: Sequence[str],
        out: Path | None = None,
        *,
        actor: Account,
        language: str = SOURCE,
    ) -> tuple[Path, ...]:
        """Write one file per format and return their paths, in the order of ``formats``.

        Args:
            subjects: Sessions or takes.
            formats: Names of ``FORMATS``.
            out: Folder, or file for one format; by default the clinic's reports, named after the subject.
            actor: Who asks (verb "view").
            language: Of the formats that people read.

        Raises:
            Refused: A subject, format or language is unknown, or a file is damaged.
        """
        require(actor, "view")
        chosen = [format_named(name) for name in formats]
        if not chosen:
            raise Refused("report format", "none", "one of " + ", ".join(FORMATS), "name one with --format")
        targets = self._targets(subjects, chosen, out)
        paths = [self._sessions.unchanged(subject) for subject in subjects]
        report = _built(paths, self._passive(paths), self._whose(paths))
        with headed(self._presentation.name()):
            contents = [made.made(report, language) for made in chosen]
        for content, target in zip(contents, targets, strict=True):
            write_whole(target, content)
        self._audit.note(actor, "report", ", ".join(Path(str(subject)).stem for subject in subjects))
        return targets

    def rendered(self, format_name: str, *subjects: str | Path, language: str = SOURCE) -> bytes:
        """Report of sessions or takes in one format; one that people read is in the language.

        Raises:
            Refused: There is no such format, subject or language, or its file is damaged.
        """
        format_named(format_name)
        paths = [self._sessions.unchanged(subject) for subject in subjects]
        runs, whose = self._passive(paths), self._whose(paths)
        return (
            aside(_rendered, format_name, paths, runs, whose, language, self._presentation.name())
            if self._serving
            else _rendered(format_name, paths, runs, whose, language, self._presentation.name())
        )

    def download(
        self, actor: Account, format_name: str, *subjects: str | Path, language: str = SOURCE
    ) -> bytes:
        """As ``rendered``, noted in the audit.

        Args:
            actor: Who takes it away (verb "view").
            format_name: A name of ``FORMATS``.
            subjects: Sessions or takes.
            language: Of the formats that people read.

        Raises:
            Refused: The actor may not; there is no such format or subject, or its file is damaged.
        """
        require(actor, "view")
        made = self.rendered(format_name, *subjects, language=language)
        self._audit.note(actor, "report", ", ".join(Path(str(one)).stem for one in subjects), format_name)
        return made

    def html(self, *subjects: str | Path, language: str = SOURCE) -> str:
        """Report of sessions or takes as a self-contained page.

        Raises:
            Refused: There is no such subject, or its file is damaged.
        """
        return self.rendered("html", *subjects, language=language).decode()

    def json(self, *subjects: str | Path) -> bytes:
        """Report of sessions or takes as JSON, SI units.

        Raises:
            Refused: There is no such subject, or its file is damaged.
        """
        return self.rendered("json", *subjects)

    def _passive(self, paths: Sequence[Path]) -> dict[Path, list[Path]]:
        """Passive runs of the same patient and day, by path of the clinic's sessions."""
        root, found = self._folder.root, dict[Path, list[Path]]()
        rows = {root / row.path: row for row in self._catalogue.sessions()}
        for path in paths:
            row = rows.get(path) or rows.get(path.absolute())
            if row is not None:
                found[path] = [root / run.path for run in passive_runs(row, tuple(rows.values()))]
        return found

    def _whose(self, paths: Sequence[Path]) -> dict[Path, str]:
        """The patient that the catalogue names for each of the clinic's sessions."""
        root = self._folder.root
        known = {root / row.path: row.patient for row in self._catalogue.sessions() if row.patient}
        return {path: known[path.absolute()] for path in paths if path.absolute() in known}

    def _targets(
        self, subjects: Sequence[str | Path], formats: Sequence[Format], out: Path | None
    ) -> tuple[Path, ...]:
        if out is not None and len(formats) == 1 and out.name.endswith(formats[0].suffix):
            return (out,)
        folder = self._folder.reports if out is None else out
        stem = "-".join(self._sessions.path(subject).stem for subject in subjects[:2])
        if len(subjects) > 2:
            stem += f"-and-{len(subjects) - 2}-more"
        return tuple(folder / f"{stem}{made.suffix}" for made in formats)


def format_named(name: str) -> Format:
    """The format of that name.

    Raises:
        Refused: There is none.
    """
    if name not in FORMATS:
        raise Refused("report format", repr(name), "one of " + ", ".join(FORMATS), "choose one of them")
    return FORMATS[name]


def write_whole(target: Path, content: bytes) -> None:
    """Write a report whole; an older one of that name is replaced."""
    target.parent.mkdir(parents=True, exist_ok=True)
    working = target.with_name(f".{target.name}.part")
    try:
        working.write_bytes(content)
        working.replace(target)
    finally:
        working.unlink(missing_ok=True)


def _rendered(
    format_name: str,
    paths: Sequence[Path],
    passive: Mapping[Path, Sequence[Path]],
    whose: Mapping[Path, str],
    language: str,
    clinic: str,
) -> bytes:
    with headed(clinic):
        return FORMATS[format_name].made(_built(paths, passive, whose), language)


def _built(
    paths: Sequence[Path], passive: Mapping[Path, Sequence[Path]], whose: Mapping[Path, str]
) -> Report:
    """The report, unless a file is of another patient than the one it is filed under.

    Raises:
        Refused: It is, or it cannot be measured.
    """
    report = build_report(paths, passive=passive)
    for path, summary in zip(paths, report.summaries, strict=True):
        written, filed = summary.header.subject_id, whose.get(path, "")
        if filed and written != filed:
            raise Refused(
                f"session {path.stem}",
                f"a file of {written or 'nobody'}",
                f"of {filed}, under whom it is filed",
                "find out whose hand it was before anything is read from it",
            )
    return report
