"""What assessments found: active and passive range, tone by speed, target tracking."""

from __future__ import annotations

import math

from starlette.responses import Response

from rehab_app.web.pages.patient_tabs import patient_head
from rehab_app.web.visit import Visit

SHOWN = 5


def assessments(visit: Visit) -> Response:
    """The newest results of each protocol; the range's first one beside them."""
    clinic, patient_id = visit.site.clinic, visit.part("patient")
    patient = clinic.patients.get(patient_id)
    ranges = clinic.protocols.history(patient_id, "range")
    return visit.page(
        "patient_assessments.html.j2",
        head=patient_head(visit, patient, "assessments"),
        patient=patient,
        latest=ranges[0] if ranges else None,
        first=ranges[-1] if len(ranges) > 1 else None,
        tones=clinic.protocols.history(patient_id, "tone")[:SHOWN],
        tracked=clinic.protocols.history(patient_id, "tracking")[:SHOWN],
        degrees=degrees,
    )


def degrees(angle_rad: float | None) -> str:
    """An angle for a table, a dash where there is none."""
    return "–" if angle_rad is None else f"{math.degrees(angle_rad) + 0.0:.0f}"
