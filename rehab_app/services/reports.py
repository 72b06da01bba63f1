"""Reports of takes and sessions."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from rehab_app.access import Account, require
from rehab_app.config import ClinicFolder
from rehab_app.errors import Refused
from rehab_app.services.audit import Audit
from rehab_app.services.sessions import Sessions
from sessions.reports import Report, build_report, render_html, render_json

FORMATS = ("html", "json")


class Reports:
    """Reports; a subject is a path or the catalogue id of a session or take.

    Args:
        folder: The clinic folder.
        sessions: Where subjects are found.
        audit: Where written reports are noted.
    """

    def __init__(self, folder: ClinicFolder, sessions: Sessions, audit: Audit) -> None:
        self._folder = folder
        self._sessions = sessions
        self._audit = audit

    def report(
        self,
        subjects: Sequence[str | Path],
        formats: Sequence[str],
        out: Path | None = None,
        *,
        actor: Account,
    ) -> tuple[Path, ...]:
        """Write one file per format and return their paths, in the order of ``formats``.

        Args:
            subjects: Sessions or takes.
            formats: "html", "json" or both.
            out: Folder, or file for one format; by default the clinic's reports, named after the subject.
            actor: Who asks (verb "view").

        Raises:
            Refused: A subject or format is unknown, or a file is damaged.
        """
        require(actor, "view")
        self._check(formats)
        targets = self._targets(subjects, formats, out)
        report = self._build(subjects)
        for name, target in zip(formats, targets, strict=True):
            content = render_html(report).encode("utf-8") if name == "html" else render_json(report)
            _write(target, content)
        self._audit.note(actor, "report", ", ".join(Path(str(subject)).stem for subject in subjects))
        return targets

    def html(self, *subjects: str | Path) -> str:
        """Report of sessions or takes as a self-contained page.

        Raises:
            Refused: There is no such subject, or its file is damaged.
        """
        return render_html(self._build(subjects))

    def json(self, *subjects: str | Path) -> bytes:
        """Report of sessions or takes as JSON, SI units.

        Raises:
            Refused: There is no such subject, or its file is damaged.
        """
        return render_json(self._build(subjects))

    def _build(self, subjects: Sequence[str | Path]) -> Report:
        return build_report([self._sessions.path(subject) for subject in subjects])

    def _check(self, formats: Sequence[str]) -> None:
        for name in formats:
            if name not in FORMATS:
                raise Refused(
                    "report format", repr(name), "one of " + ", ".join(FORMATS), "choose one of them"
                )
        if not formats:
            raise Refused("report format", "none", "one of " + ", ".join(FORMATS), "name one with --format")

    def _targets(
        self, subjects: Sequence[str | Path], formats: Sequence[str], out: Path | None
    ) -> tuple[Path, ...]:
        if out is not None and len(formats) == 1 and out.suffix == f".{formats[0]}":
            return (out,)
        folder = self._folder.reports if out is None else out
        stem = "-".join(self._sessions.path(subject).stem for subject in subjects[:2])
        if len(subjects) > 2:
            stem += f"-and-{len(subjects) - 2}-more"
        return tuple(folder / f"{stem}.{name}" for name in formats)


def _write(target: Path, content: bytes) -> None:
    """Write a report whole; an older one of that name is replaced."""
    target.parent.mkdir(parents=True, exist_ok=True)
    working = target.with_name(f".{target.name}.part")
    try:
        working.write_bytes(content)
        working.replace(target)
    finally:
        working.unlink(missing_ok=True)
