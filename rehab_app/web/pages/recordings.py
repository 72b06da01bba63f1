"""Takes and sessions: lists, review with a time bar, approval, reports."""

from __future__ import annotations

from starlette.responses import Response

from rehab_app.errors import Refused
from rehab_app.services.rows import SessionRow
from rehab_app.web.policy import REPORT
from rehab_app.web.visit import Visit
from sessions.catalogue import Patient


def takes(visit: Visit) -> Response:
    """All takes, newest first."""
    return visit.page("takes.html.j2", takes=visit.site.clinic.takes.list())


def take(visit: Visit) -> Response:
    """One take: look at it, then approve it."""
    row = visit.site.clinic.takes.get(catalogue_id(visit.part("recording")))
    return visit.page("take.html.j2", take=row, why_no_names=visit.site.clinic.marker_names.why_not(row.id))


def approve(visit: Visit) -> Response:
    """Approve exactly this file for play."""
    named = catalogue_id(visit.part("recording"))
    visit.site.clinic.takes.approve(named, visit.account)
    back = "/live" if visit.asked("back") == "live" else f"/takes/{named}"
    return visit.go(back, f"Take {named} is approved by {visit.account.name}.")


def sessions(visit: Visit) -> Response:
    """All sessions, newest first."""
    rows = visit.site.clinic.sessions.list()
    return visit.page("sessions.html.j2", sessions=[(row, _patient(visit, row)) for row in rows])


def session(visit: Visit) -> Response:
    """One session with its replay."""
    row = visit.site.clinic.sessions.get(catalogue_id(visit.part("recording")))
    return visit.page("session.html.j2", session=row, patient=_patient(visit, row))


def report(visit: Visit) -> Response:
    """The page around a report."""
    named = catalogue_id(visit.part("recording"))
    kind = "takes" if visit.request.url.path.startswith("/takes/") else "sessions"
    row = visit.site.clinic.takes.get(named) if kind == "takes" else visit.site.clinic.sessions.get(named)
    patient = _patient(visit, row) if isinstance(row, SessionRow) else None
    return visit.page("report.html.j2", recording=row, kind=kind, patient=patient)


def report_html(visit: Visit) -> Response:
    """The report itself: self-contained, and no script may run in it."""
    html = visit.site.clinic.reports.html(catalogue_id(visit.part("recording")))
    return Response(
        html,
        media_type="text/html",
        headers={"content-security-policy": REPORT, "x-frame-options": "SAMEORIGIN"},
    )


def report_json(visit: Visit) -> Response:
    """The report's numbers, SI units."""
    named = catalogue_id(visit.part("recording"))
    content = visit.site.clinic.reports.json(named)
    disposition = f'attachment; filename="report-{named}.json"'
    return Response(content, media_type="application/json", headers={"content-disposition": disposition})


def _patient(visit: Visit, row: SessionRow) -> Patient | None:
    return visit.site.patients.get(row.patient_id) if row.patient_id else None


def catalogue_id(named: str) -> str:
    """The catalogue id in a path. A browser never names files, so anything else is refused."""
    if not (named.isascii() and named.isalnum()):
        raise Refused(
            f"recording {named!r}", "no catalogue id", "letters and digits", "choose it from the list"
        )
    return named
