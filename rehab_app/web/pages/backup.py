"""Backups and retention: when the last copy was made, where copies lie, how one comes back, who is due."""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path

from starlette.responses import FileResponse, Response

from rehab_app.errors import REFUSALS, Refused
from rehab_app.web.language import _
from rehab_app.web.pages.asked import not_overtaken, whole
from rehab_app.web.pages.typed import sentence_of
from rehab_app.web.visit import Visit

PAGE = "/clinic/backup"


@dataclass(frozen=True, slots=True)
class StoredBackup:
    """One row of the list.

    Attributes:
        name: File name.
        utc_ns: When it was written.
        megabytes: Its size.
    """

    name: str
    utc_ns: int
    megabytes: float


def backup(visit: Visit) -> Response:
    """The page."""
    return _shown(visit)


def _shown(visit: Visit, refused: str = "", problem: str = "") -> Response:
    """The page; the form that was refused holds what was typed."""
    privacy = visit.site.clinic.privacy
    last = privacy.backups.last()
    now_ns = time.time_ns()
    return visit.page(
        "clinic_backup.html.j2",
        status=409 if refused else 200,
        problems={refused: problem},
        was={"place": privacy.place.place(), "years": privacy.retention.years()},
        last=last,
        last_days=None if last is None else (now_ns - last.utc_ns) // 86_400_000_000_000,
        has_key=privacy.backups.key() is not None,
        place=visit.asked("place") if refused == "place" else privacy.place.place(),
        stored=[_row(path) for path in privacy.place.stored()],
        years=visit.asked("years") if refused == "years" else privacy.retention.years(),
        due=[visit.site.clinic.patients.get(one) for one in privacy.retention.due()],
    )


def set_passphrase(visit: Visit) -> Response:
    """Set the passphrase; it is typed twice and kept nowhere."""
    if visit.asked("passphrase") != visit.asked("again"):
        remedy = "type the same one twice"
        raise Refused("backup passphrase", "typed in two different ways", "the same twice", remedy)
    visit.site.clinic.privacy.backups.set_passphrase(visit.account, visit.asked("passphrase"))
    return visit.go(PAGE, _("The passphrase is set. Keep it in a safe: without it no backup opens."))


def set_place(visit: Visit) -> Response:
    """Choose the folder of the backups."""
    kept = visit.site.clinic.privacy.place
    try:
        not_overtaken(visit, "folder of the backups", str(kept.place()), visit.asked("place"))
        kept.set_place(visit.account, Path(visit.asked("place")))
    except REFUSALS as refusal:
        return _shown(visit, "place", sentence_of(refusal))
    return visit.go(PAGE, _("Backups go to that folder from now on."))


def make(visit: Visit) -> Response:
    """Back up now."""
    made = visit.site.clinic.privacy.place.make_stored(visit.account)
    return visit.go(PAGE, _("Backed up as %(name)s.") % {"name": made.name})


def download(visit: Visit) -> Response:
    """One stored backup as a file."""
    path = visit.site.clinic.privacy.place.stored_named(visit.part("name"))
    visit.site.clinic.audit.note_later(visit.account.name, "download backup", "", path.name)
    return FileResponse(path, media_type="application/octet-stream", filename=path.name)


def restore(visit: Visit) -> Response:
    """Restore a stored backup into a new folder; the clinic that is open stays as it is."""
    restored = visit.site.clinic.privacy.place.restore_beside(
        visit.account, visit.asked("name"), visit.asked("passphrase")
    )
    said = _(
        "Restored into %(folder)s. To work with it, end this server and start it with --data and that folder."
    )
    return visit.go(PAGE, said % {"folder": restored.folder})


def set_retention(visit: Visit) -> Response:
    """Change how long patients are kept."""
    kept = visit.site.clinic.privacy.retention
    try:
        years = whole(visit, "years", "retention")
        not_overtaken(visit, "retention", f"{kept.years()}", f"{years}")
        kept.set_years(visit.account, years)
    except Refused as refusal:
        return _shown(visit, "years", sentence_of(refusal))
    return visit.go(PAGE, _("The retention is changed. Nothing is erased by itself."))


def _row(path: Path) -> StoredBackup:
    found = path.stat()
    return StoredBackup(path.name, found.st_mtime_ns, found.st_size / 1e6)
