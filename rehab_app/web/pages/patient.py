"""One patient: the overview, limits, sessions and takes."""

from __future__ import annotations

from starlette.responses import Response

from rehab_app.services.diagnosis import precautions
from rehab_app.web.pages import patient_words as words
from rehab_app.web.pages.patient_tabs import patient_head
from rehab_app.web.visit import Visit

_NEWEST = 5


def overview(visit: Visit) -> Response:
    """What must be known before anything is done with this hand, and what happened last."""
    clinic, named = visit.site.clinic, visit.part("patient")
    shown = clinic.patients.get(named)
    record = clinic.clinical.record(named)
    sessions = clinic.patients.sessions(named)
    return visit.page(
        "patient.html.j2",
        head=patient_head(visit, shown),
        patient=shown,
        record=record,
        cautions=precautions(record),
        locks=clinic.clinical.mode_locks(named),
        limits=clinic.limit_history.show(named),
        plan=clinic.plans.current(named),
        series=clinic.outcomes.series(named),
        entries=[one for one in clinic.journal.entries(named) if not one.corrected_by][:_NEWEST],
        sessions=sessions[:_NEWEST],
        session_count=len(sessions),
        hands=clinic.hands.list(named),
        words=words,
    )


def limits(visit: Visit) -> Response:
    """The limits of today and how they came about."""
    named = visit.part("patient")
    shown = visit.site.clinic.patients.get(named)
    return visit.page(
        "patient_limits.html.j2",
        head=patient_head(visit, shown, "limits"),
        patient=shown,
        limits=visit.site.clinic.limit_history.show(named),
    )


def sessions(visit: Visit) -> Response:
    """Every session of a patient, and the takes that were recorded of the patient's own hands."""
    patients, named = visit.site.clinic.patients, visit.part("patient")
    shown = patients.get(named)
    return visit.page(
        "patient_sessions.html.j2",
        head=patient_head(visit, shown, "sessions"),
        patient=shown,
        sessions=patients.sessions(named),
        takes=patients.takes(named),
    )
