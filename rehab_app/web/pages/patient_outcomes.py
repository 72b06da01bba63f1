"""Outcome measures of a patient: enter, correct, first beside last."""

from __future__ import annotations

import math
from datetime import UTC, datetime
from itertools import pairwise

from starlette.responses import Response

from rehab_app.errors import REFUSALS, Refused
from rehab_app.services.outcome_measures import MEASURES, Measure, measure
from rehab_app.web.language import _
from rehab_app.web.pages import patient_words as words
from rehab_app.web.pages.patient_tabs import patient_head
from rehab_app.web.pages.typed import Typed
from rehab_app.web.visit import Visit
from sessions.catalogue import Patient

_NAMES = ("measure", "value", "side", "place", "measured_on", "remark", "corrects")
_THINGS = {"date of the measurement": "measured_on", "remark": "remark", "side": "side"}


def outcomes(visit: Visit) -> Response:
    """First, last and newest value of every measure, each value, and the form of one measure."""
    patient = visit.site.clinic.patients.get(visit.part("patient"))
    form = Typed(visit, _NAMES)
    form.values |= _preset(visit, patient)
    return _page(visit, patient, form)


def add_outcome(visit: Visit) -> Response:
    """Enter a value, or show the form again with what is wrong."""
    patient = visit.site.clinic.patients.get(visit.part("patient"))
    form = Typed(visit, _NAMES)
    chosen = form.read("measure", measure, MEASURES[0])
    value = form.read("value", chosen.read, math.nan)
    if form.problems:
        return _page(visit, patient, form)
    typed = form.values
    corrects = typed["corrects"]
    try:
        visit.site.clinic.outcomes.add(
            visit.account,
            patient.id,
            chosen.key,
            value,
            side=typed["side"] if chosen.sided else "",
            place=typed["place"] if chosen.places else "",
            measured_on=typed["measured_on"],
            remark=typed["remark"],
            corrects=int(corrects) if corrects.isascii() and corrects.isdecimal() else 0,
        )
    except REFUSALS as refusal:
        form.refuse(refusal, _THINGS | {f"place of {chosen.words}": "place", chosen.words: "value"})
        return _page(visit, patient, form)
    said = _("%(measure)s is entered.") % {"measure": _(words.MEASURES[chosen.key])}
    return visit.go(f"/patients/{patient.id}/outcomes?measure={chosen.key}", said)


def _preset(visit: Visit, patient: Patient) -> dict[str, str]:
    """What the form begins with: the measure that was chosen, or the value that is to be corrected."""
    wanted = visit.request.query_params
    chosen = _known(wanted.get("measure", ""))
    today = datetime.now(UTC).astimezone().date().isoformat()
    values = {"measure": chosen.key, "side": patient.side, "measured_on": today}
    number = wanted.get("corrects", "")
    for one in visit.site.clinic.outcomes.list(patient.id):
        if str(one.id) == number:
            old = measure(one.measure)
            return {
                "measure": old.key,
                "value": old.text(one.value),
                "side": one.side,
                "place": one.place,
                "measured_on": one.measured_on,
                "remark": one.remark,
                "corrects": number,
            }
    return values


def _known(key: str) -> Measure:
    try:
        return measure(key)
    except Refused:
        return MEASURES[0]


def _page(visit: Visit, patient: Patient, form: Typed) -> Response:
    held = visit.site.clinic.outcomes
    series = held.series(patient.id)
    steps = {now.id: now.value - before.value for one in series for before, now in pairwise(one.rows)}
    return visit.page(
        "patient_outcomes.html.j2",
        status=409 if form.problems else 200,
        head=patient_head(visit, patient, "outcomes"),
        patient=patient,
        series=series,
        steps=steps,
        rows=[(one, measure(one.measure)) for one in held.list(patient.id, corrected=True)],
        measures=MEASURES,
        chosen=_known(form.values["measure"]),
        asked=form.values,
        problems=form.problems,
        words=words,
    )
