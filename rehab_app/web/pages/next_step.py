"""The next step of a patient's therapy: proposed from the last sessions, answered by a therapist."""

from __future__ import annotations

from starlette.responses import Response

from rehab_app.errors import Refused
from rehab_app.web.language import _, marked, written
from rehab_app.web.pages.asked import not_overtaken, number
from rehab_app.web.pages.typed import sentence_of
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
    return _page(visit)


def _page(visit: Visit, problem: str = "") -> Response:
    """The page; a refused aim stands there as it was typed."""
    patient = visit.site.patients.get(visit.part("patient"))
    proposals = visit.site.clinic.proposals
    made, answers = proposals.of_patient(patient.id), proposals.answers(patient.id, 20)
    words = visit.site.clinic.exercises.words
    return visit.page(
        "report_next.html.j2",
        status=409 if problem else 200,
        problem=problem,
        typed=visit.asked("percent"),
        patient=patient,
        proposals=[(one, words(one.item.exercise), _shown(one.changes)) for one in made],
        answers=[(one, words(one.exercise), _shown(one.changes)) for one in answers],
        target=_aim(visit),
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
    try:
        percent = number(visit, "percent", "aim of success", "a number of percent, such as 70")
        not_overtaken(visit, "aim of success", _aim(visit), written(percent))
        visit.site.clinic.proposals.set_target(visit.account, percent / 100.0)
    except Refused as refusal:
        return _page(visit, sentence_of(refusal))
    return visit.go(f"/patients/{visit.part('patient')}/next", _("The aim is set."))


def _aim(visit: Visit) -> str:
    return written(round(100 * visit.site.clinic.proposals.target(), 2))


def _shown(changes: tuple[tuple[str, float, float], ...]) -> list[tuple[str, str, str]]:
    """Name, now and then, as a person reads them."""
    return [(_(_WORDS[name]), _number(name, now), _number(name, then)) for name, now, then in changes]


def _number(name: str, value: float) -> str:
    return f"{written(100 * value, 0)} %" if name in _PERCENT else written(value)


def _paths(visit: Visit) -> set[str]:
    return {getattr(route, "path", "") for route in visit.request.app.routes}
