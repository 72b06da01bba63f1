"""Patients: the list, the form, one patient."""

from __future__ import annotations

from starlette.responses import Response

from rehab_app.errors import Refused
from rehab_app.web.visit import Visit

_EMPTY = {
    "given_name": "",
    "family_name": "",
    "birth_date": "",
    "side": "",
    "hand_length_cm": "18.9",
    "impairment": "",
}


def patients(visit: Visit) -> Response:
    """Everybody who is not archived."""
    return visit.page("patients.html.j2", patients=visit.site.clinic.patients.list())


def new_patient(visit: Visit) -> Response:
    """The form of a new patient."""
    return visit.page("new_patient.html.j2", asked=_EMPTY, sentence="")


def add_patient(visit: Visit) -> Response:
    """Add a patient, or show the form again with what is wrong."""
    asked = {name: visit.asked(name) for name in _EMPTY}
    try:
        added = visit.site.clinic.patients.add(
            visit.account,
            given_name=_needed(asked, "given_name", "given name"),
            family_name=_needed(asked, "family_name", "family name"),
            birth_date=_needed(asked, "birth_date", "birth date"),
            side=asked["side"],
            hand_length_m=_length_m(asked["hand_length_cm"]),
            impairment=asked["impairment"],
        )
    except Refused as refusal:
        return visit.page("new_patient.html.j2", status=409, asked=asked, sentence=str(refusal))
    return visit.go(f"/patients/{added.id}", f"{added.given_name} {added.family_name} was added.")


def patient(visit: Visit) -> Response:
    """One patient with their sessions, newest first."""
    shown = visit.site.clinic.patients.get(visit.part("patient"))
    held = [row for row in visit.site.clinic.sessions.list() if row.patient_id == shown.id]
    return visit.page("patient.html.j2", patient=shown, sessions=held)


def _needed(asked: dict[str, str], name: str, words: str) -> str:
    """A field that identifies the patient, so it may not be empty."""
    if not asked[name]:
        raise Refused(words, "empty", "filled in (it identifies the patient)", "fill it in")
    return asked[name]


def _length_m(text: str) -> float:
    try:
        return float(text.replace(",", ".")) / 100.0
    except ValueError:
        raise Refused(
            "hand length", repr(text), "a number of centimetres", "measure wrist crease to middle fingertip"
        ) from None
