"""The library of exercises: list, one exercise with its pictures, the clinic's own."""

from __future__ import annotations

from urllib.parse import quote

from starlette.responses import Response

from rehab_app.errors import Refused
from rehab_app.services.exercise_records import PURPOSES
from rehab_app.services.exercises import holds
from rehab_app.web.language import _
from rehab_app.web.pages.choices import patient_choices
from rehab_app.web.visit import Visit
from rehab_app.web.words import MODES
from sessions.catalogue import TakeFilter

_TAKES = 8


def exercises(visit: Visit) -> Response:
    """The library, all of it or what was searched for."""
    return _list(visit)


def add(visit: Visit) -> Response:
    """Add an exercise of the clinic's own, or show the form again with what is wrong."""
    try:
        added = visit.site.clinic.exercises.add(
            visit.account, visit.asked("name"), visit.asked("description")
        )
    except Refused as refusal:
        return _list(visit, str(refusal))
    return visit.go(f"/exercises/{quote(added.name, safe='')}", _("The exercise was added."))


def exercise(visit: Visit) -> Response:
    """One exercise: how it is done, its takes, record or prescribe it."""
    clinic = visit.site.clinic
    shown = clinic.exercises.get(visit.part("name"))
    side = visit.request.query_params.get("side", "right")
    return visit.page(
        "exercise.html.j2",
        say=_,
        exercise=shown,
        purposes=PURPOSES,
        modes=MODES,
        side=side if side in ("left", "right") else "right",
        takes=clinic.takes.shelf.find(TakeFilter(exercise=shown.name), on_a_page=_TAKES).takes,
        patients=patient_choices(visit) if visit.account.may("prescribe") else None,
    )


def picture(visit: Visit) -> Response:
    """Its start and end posture, drawn."""
    svg = visit.site.clinic.exercises.picture(visit.part("name"), visit.part("view"), visit.part("side"))
    return Response(svg, media_type="image/svg+xml", headers={"cache-control": "private, max-age=3600"})


def prescribe(visit: Visit) -> Response:
    """On to the plan of the chosen patient, where the exercise is filled in."""
    asked = visit.request.query_params
    patient = visit.site.clinic.patients.get(asked.get("patient", ""))
    shown = visit.site.clinic.exercises.get(asked.get("exercise", ""))
    take = quote(asked.get("take", ""), safe="")
    return visit.go(f"/patients/{patient.id}/plan?add={quote(shown.name, safe='')}&take={take}#item")


def _list(visit: Visit, sentence: str = "") -> Response:
    words = visit.request.query_params.get("words", "")[:80]
    purpose = visit.request.query_params.get("purpose", "")
    known = purpose if purpose in PURPOSES else ""
    clinic = visit.site.clinic
    return visit.page(
        "exercises.html.j2",
        say=_,
        status=409 if sentence else 200,
        exercises=[
            one
            for one in clinic.exercises.list(purpose=known)
            if holds(f"{_(one.words)} {_(one.purpose)} {_(one.joints)} {one.name}", words)
        ],
        counted=clinic.takes.shelf.counts(),
        words=words,
        purpose=known,
        purposes=PURPOSES,
        asked={"name": visit.asked("name"), "description": visit.asked("description")},
        sentence=sentence,
    )
