"""Paths of the patients: the list, and the pages of one patient that are not of a part of their own."""

from __future__ import annotations

from collections.abc import Callable

from starlette.responses import Response
from starlette.routing import BaseRoute, Route

from rehab_app.access import Verb
from rehab_app.web.pages import (
    assessments,
    patient,
    patient_diagnosis,
    patient_journal,
    patient_outcomes,
    patients,
)
from rehab_app.web.visit import Visit, action, page


def patient_routes() -> list[BaseRoute]:
    """The routes; what a patient's page writes is refused back to the list."""

    def shows(tail: str, answer: Callable[[Visit], Response], verb: Verb = "view") -> BaseRoute:
        return Route(f"/patients/{{patient}}{tail}", page(answer, verb), methods=["GET"])

    def does(tail: str, answer: Callable[[Visit], Response], verb: Verb) -> BaseRoute:
        return Route(f"/patients/{{patient}}{tail}", action(answer, verb, "/patients"), methods=["POST"])

    return [
        Route("/patients", page(patients.patients), methods=["GET"]),
        Route("/patients", action(patients.add_patient, "prescribe", "/patients"), methods=["POST"]),
        Route("/patients/new", page(patients.new_patient, "prescribe"), methods=["GET"]),
        shows("", patient.overview),
        shows("/edit", patients.edit_patient, "prescribe"),
        does("/edit", patients.change_patient, "prescribe"),
        does("/archive", patients.archive, "prescribe"),
        does("/unarchive", patients.unarchive, "prescribe"),
        shows("/diagnosis", patient_diagnosis.diagnosis),
        does("/diagnosis", patient_diagnosis.state_record, "prescribe"),
        does("/unlock", patient_diagnosis.unlock, "prescribe"),
        does("/lock", patient_diagnosis.lock, "view"),
        shows("/limits", patient.limits),
        shows("/assessments", assessments.assessments),
        shows("/outcomes", patient_outcomes.outcomes),
        does("/outcomes", patient_outcomes.add_outcome, "note"),
        shows("/journal", patient_journal.journal),
        does("/journal/note", patient_journal.write_note, "note"),
        does("/journal/pain", patient_journal.write_pain, "note"),
        does("/journal/event", patient_journal.write_event, "note"),
        shows("/sessions", patient.sessions),
    ]
