"""Reports to take away, a patient's progress, and two sessions beside each other."""

from __future__ import annotations

from starlette.responses import Response

from rehab_app.errors import Refused
from rehab_app.services.reports import format_named
from rehab_app.web.language import spoken
from rehab_app.web.pages.recordings import catalogue_id
from rehab_app.web.policy import REPORT
from rehab_app.web.visit import Visit
from sessions.reports.progress import Progress
from sessions.reports.progress_formats import PROGRESS_FORMATS


def download(visit: Visit) -> Response:
    """The report of a take or session as a file."""
    named, wanted = catalogue_id(visit.part("recording")), visit.part("format")
    made = format_named(wanted)
    content = visit.site.clinic.reports.download(visit.account, wanted, named, language=spoken())
    return _file(content, made.media_type, f"report-{named}{made.suffix}")


def progress(visit: Visit) -> Response:
    """The page around a patient's progress."""
    patient = visit.site.patients.get(visit.part("patient"))
    sessions = visit.site.clinic.catalogue.sessions(patient.id)
    return visit.page("report_progress.html.j2", patient=patient, sessions=sessions)


def progress_file(visit: Visit) -> Response:
    """Progress itself: shown where it is HTML, else a file."""
    found = visit.site.clinic.progress.of_patient(visit.part("patient"))
    return _progress(visit, found, f"progress-{found.subject_id}")


def compare(visit: Visit) -> Response:
    """Choose two sessions of a patient; where both are chosen, they are shown beside each other."""
    patient = visit.site.patients.get(visit.part("patient"))
    sessions = visit.site.clinic.catalogue.sessions(patient.id)
    first, second = _two(visit)
    known = {session.id for session in sessions}
    both = first in known and second in known and first != second
    return visit.page(
        "report_compare.html.j2", patient=patient, sessions=sessions, first=first, second=second, both=both
    )


def compare_file(visit: Visit) -> Response:
    """The comparison itself: shown where it is HTML, else a file."""
    found = visit.site.clinic.progress.comparison(*(catalogue_id(name) for name in _two(visit)))
    named = visit.part("patient")
    if found.subject_id != named:
        raise Refused("comparison", f"of {found.subject_id}", f"of {named}", "choose from the list")
    return _progress(visit, found, f"comparison-{found.subject_id}")


def _two(visit: Visit) -> tuple[str, str]:
    asked = visit.request.query_params
    return asked.get("first", ""), asked.get("second", "")


def _progress(visit: Visit, found: Progress, stem: str) -> Response:
    wanted = visit.part("format")
    if wanted == "html":
        return _shown(visit.site.clinic.progress.rendered(found, "html", spoken()))
    content = visit.site.clinic.progress.download(visit.account, found, wanted, spoken())
    suffix, media_type = PROGRESS_FORMATS[wanted]
    return _file(content, media_type, f"{stem}{suffix}")


def _shown(html: bytes) -> Response:
    """A self-contained page in which no script may run."""
    headers = {"content-security-policy": REPORT, "x-frame-options": "SAMEORIGIN"}
    return Response(html, media_type="text/html", headers=headers)


def _file(content: bytes, media_type: str, name: str) -> Response:
    disposition = f'attachment; filename="{name}"'
    return Response(content, media_type=media_type, headers={"content-disposition": disposition})
