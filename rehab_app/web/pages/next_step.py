"""The next step of a patient's therapy: proposed from the last sessions, answered by a therapist."""

from __future__ import annotations

import math

from starlette.responses import Response

from rehab_app.errors import Refused
from rehab_app.web.language import _, marked
from rehab_app.web.pages.asked import decimal
from rehab_app.web.visit import Visit

_WORDS = {
    "speed": marked("Speed"),
    "stiffness_multiple": marked("Support (× thesis gains)"),
    "resistance": marked("Resistance"),
    "range": marked("Range"),
}
_PERCENT = ("speed", "resistance", "range")


def next_step(visit: Visit) -> Response:
    """Every item of the plan with what is proposed for it, and what was answered before."""
    patient = visit.site.patients.get(visit.part("patient"))
    proposals = visit.site.clinic.proposals
    made, answers = proposals.of_patient(patient.id), proposals.answers(patient.id, 20)
    words = visit.site.clinic.exercises.words
    return visit.page(
        "report_next.html.j2",
        patient=patient,
        proposals=[(one, words(one.item.exercise), _shown(one.changes)) for one in made],
        answers=[(one, words(one.exercise), _shown(one.changes)) for one in answers],
        target=round(100 * proposals.target()),
        has_plan="/patients/{patient}/plan" in _paths(visit),
    )


def answer(visit: Visit) -> Response:
    """Accept or decline exactly what was shown."""
    named = visit.part("patient")
    back = f"/patients/{named}/next"
    accept = visit.asked("answer") == "accept"
    try:
        visit.site.clinic.proposals.answer(
            visit.account, named, visit.asked("proposal"), accept=accept, remark=visit.asked("remark")
        )
    except Refused as refusal:
        return visit.go(back, str(refusal), good=False)
    said = _("The plan is changed as proposed.") if accept else _("The proposal is declined; the plan stays.")
    return visit.go(back, said)


def aim(visit: Visit) -> Response:
    """Aim at another share of successful repetitions, for the whole clinic."""
    back, share = f"/patients/{visit.part('patient')}/next", decimal(visit.asked("percent")) / 100.0
    if not math.isfinite(share):
        return visit.go(back, _("The aim must be a number of percent, such as 70."), good=False)
    try:
        visit.site.clinic.proposals.set_target(visit.account, share)
    except Refused as refusal:
        return visit.go(back, str(refusal), good=False)
    return visit.go(back, _("The aim is set."))


def _shown(changes: tuple[tuple[str, float, float], ...]) -> list[tuple[str, str, str]]:
    """Name, now and then, as a person reads them."""
    return [(_(_WORDS[name]), _number(name, now), _number(name, then)) for name, now, then in changes]


def _number(name: str, value: float) -> str:
    return f"{100 * value:.0f} %" if name in _PERCENT else f"{value:g}"


def _paths(visit: Visit) -> set[str]:
    return {getattr(route, "path", "") for route in visit.request.app.routes}
