"""Sessions: the list, review with a time bar; reports of sessions and takes."""

from __future__ import annotations

from starlette.responses import Response

from rehab_app.errors import Refused
from rehab_app.services.rows import SessionRow
from rehab_app.web.language import spoken
from rehab_app.web.policy import REPORT
from rehab_app.web.visit import Visit
from sessions.catalogue import Patient

_LONGEST_ID = 64


def sessions(visit: Visit) -> Response:
    """All sessions, newest first, page by page."""
    asked = visit.request.query_params.get("page", "1")
    number = int(asked) if asked.isascii() and asked.isdecimal() and len(asked) < 7 else 1
    found = visit.site.clinic.sessions.page(number)
    named = visit.site.patients
    rows = [(row, named.get(row.patient_id) if row.patient_id else None) for row in found.rows]
    return visit.page("sessions.html.j2", sessions=rows, found=found)


def session(visit: Visit) -> Response:
    """One session with its replay."""
    clinic = visit.site.clinic
    row = clinic.sessions.get(catalogue_id(visit.part("recording")))
    of_patient = clinic.sessions.list(row.patient_id) if row.patient_id else ()
    others = [one for one in of_patient if one.id != row.id]
    chosen = visit.request.query_params.get("with", "")
    return visit.page(
        "session.html.j2",
        session=row,
        patient=_patient(visit, row),
        others=others[:50],
        second=next((one for one in others if one.id == chosen), None),
        take_id=row.take_id if chosen == row.take_id else "",
    )


def report(visit: Visit) -> Response:
    """The page around a report."""
    named = catalogue_id(visit.part("recording"))
    kind = "takes" if visit.request.url.path.startswith("/takes/") else "sessions"
    row = visit.site.clinic.takes.get(named) if kind == "takes" else visit.site.clinic.sessions.get(named)
    patient = _patient(visit, row) if isinstance(row, SessionRow) else None
    return visit.page("report.html.j2", recording=row, kind=kind, patient=patient)


def report_html(visit: Visit) -> Response:
    """The report itself: self-contained, and no script may run in it."""
    html = visit.site.clinic.reports.html(catalogue_id(visit.part("recording")), language=spoken())
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
    if not (named.isascii() and named.isalnum() and len(named) <= _LONGEST_ID):
        raise Refused(
            f"recording {named[:40]!r}", "no catalogue id", "letters and digits", "choose it from the list"
        )
    return named
