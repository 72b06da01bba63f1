"""The journal of a patient: notes, pain, adverse events, check-ins; pain over time."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from typing import Any

from starlette.responses import Response

from rehab_app.errors import REFUSALS, Refused
from rehab_app.services.journal import AdverseEvent, Entry, PainPoint, PainReport
from rehab_app.services.journal_records import SEVERITIES, WHENS
from rehab_app.web.language import _
from rehab_app.web.pages import patient_words as words
from rehab_app.web.pages.patient_tabs import patient_head
from rehab_app.web.pages.typed import Typed
from rehab_app.web.visit import Visit
from sessions.catalogue import Patient

_NAMES = ("corrects", "text", "score", "place", "when", "remark", "severity", "happened", "done")
_THINGS = {
    "note": "text",
    "pain": "score",
    "place of the pain": "place",
    "when the pain was felt": "when",
    "remark on the pain": "remark",
    "severity": "severity",
    "what happened": "happened",
    "what was done": "done",
}
_WIDTH, _HEIGHT, _LEFT, _RIGHT, _TOP, _BOTTOM = 1200.0, 200.0, 34.0, 12.0, 12.0, 26.0


@dataclass(frozen=True, slots=True)
class PainDot:
    """A pain score in the chart, px."""

    x: float
    y: float
    point: PainPoint


def journal(visit: Visit) -> Response:
    """Everything that was written, newest first, with the forms."""
    patient = visit.site.clinic.patients.get(visit.part("patient"))
    form = Typed(visit, _NAMES)
    number = visit.request.query_params.get("corrects", "")
    for one in visit.site.clinic.journal.entries(patient.id):
        if str(one.id) == number:
            old = {name: "" if value is None else str(value) for name, value in asdict(one.what).items()}
            form.values |= {"corrects": number, "kind": one.kind, **old}
    return _page(visit, patient, form)


def write_note(visit: Visit) -> Response:
    """Write a note."""
    writes = visit.site.clinic.journal.note

    def write(form: Mapping[str, str], **to: Any) -> Entry:
        return writes(visit.account, text=form["text"], **to)

    return _written(visit, "note", write)


def write_pain(visit: Visit) -> Response:
    """Write a pain."""
    writes = visit.site.clinic.journal.pain

    def write(form: Mapping[str, str], **to: Any) -> Entry:
        report = PainReport(_score(form["score"]), form["place"], form["when"], form["remark"])
        return writes(visit.account, report=report, **to)

    return _written(visit, "pain", write)


def write_event(visit: Visit) -> Response:
    """Write an adverse event."""
    writes = visit.site.clinic.journal.adverse_event

    def write(form: Mapping[str, str], **to: Any) -> Entry:
        event = AdverseEvent(form["severity"], form["happened"], form["done"])
        return writes(visit.account, event=event, **to)

    return _written(visit, "adverse-event", write)


def _written(visit: Visit, kind: str, write: Callable[..., Entry]) -> Response:
    """Write an entry, or show the form again with what is wrong."""
    patient = visit.site.clinic.patients.get(visit.part("patient"))
    form = Typed(visit, _NAMES)
    form.values["kind"] = kind
    old = form.values["corrects"]
    corrects = int(old) if old.isascii() and old.isdecimal() and len(old) < 10 else 0
    try:
        entry = write(form.values, patient_id=patient.id, corrects=corrects)
    except REFUSALS as refusal:
        form.refuse(refusal, _THINGS)
        return _page(visit, patient, form)
    back = f"/patients/{patient.id}" + ("" if visit.asked("back") == "overview" else "/journal")
    return visit.go(back, _("Entry %(number)s is written.") % {"number": entry.id})


def _score(text: str) -> int:
    if not (text.isascii() and text.isdecimal() and len(text) < 4):
        raise Refused(
            "pain", repr(text[:40]) if text else "not chosen", "0 (none) to 10 (worst)", "choose it"
        )
    return int(text)


def _page(visit: Visit, patient: Patient, form: Typed) -> Response:
    held = visit.site.clinic.journal
    return visit.page(
        "patient_journal.html.j2",
        status=409 if form.problems else 200,
        head=patient_head(visit, patient, "journal"),
        patient=patient,
        entries=held.entries(patient.id),
        dots=pain_dots(held.pain_course(patient.id)),
        size=(_WIDTH, _HEIGHT, _LEFT, _RIGHT, _TOP, _BOTTOM),
        writing=form.values.get("kind", ""),
        asked=form.values,
        problems=form.problems,
        whens=WHENS,
        severities=SEVERITIES,
        words=words,
    )


def pain_dots(points: tuple[PainPoint, ...]) -> tuple[PainDot, ...]:
    """Where the scores stand in the chart: time from left to right, 10 at the top; a single one midway."""
    if not points:
        return ()
    first, span = points[0].utc_ns, points[-1].utc_ns - points[0].utc_ns
    wide, high = _WIDTH - _LEFT - _RIGHT, _HEIGHT - _TOP - _BOTTOM
    return tuple(
        PainDot(
            round(_LEFT + wide * ((one.utc_ns - first) / span if span else 0.5), 1),
            round(_TOP + high * (1.0 - one.score / 10.0), 1),
            one,
        )
        for one in points
    )
