"""Takes: the list with its filters, one take to look at, approve, withdraw, retouch and compare."""

from __future__ import annotations

from dataclasses import dataclass

from starlette.responses import Response

from rehab_app.errors import Refused
from rehab_app.services.rows import TakeRow
from rehab_app.services.take_chart import joint_chart
from rehab_app.services.take_quality import TakeQuality, quality_of
from rehab_app.web.language import _
from rehab_app.web.pages.recordings import catalogue_id
from rehab_app.web.pages.retouch_form import DIGIT_CHOICES, SMOOTHING, done_to, plain_form, wish_of
from rehab_app.web.visit import Visit
from sessions.catalogue import Patient

_FILTERS = ("exercise", "side", "approval", "patient")
_ON_A_PAGE = 200


@dataclass(frozen=True, slots=True)
class Mirroring:
    """For whom a take will be mirrored.

    Attributes:
        patient: The patient whose hand was recorded.
        plays_on: Side of the hand that it will be played on.
        mirrored: Whether that is the other one.
    """

    patient: Patient
    plays_on: str
    mirrored: bool


def takes(visit: Visit) -> Response:
    """Takes, the newest first, those that the filters let through; the filters narrow what is too many."""
    clinic = visit.site.clinic
    rows = clinic.takes.list()
    asked = {name: visit.request.query_params.get(name, "") for name in _FILTERS}
    subjects = {row.subject for row in rows}
    patients = {one.id: one for one in clinic.patients.list() if one.id in subjects}
    found = [row for row in rows if _passes(row, asked)]
    return visit.page(
        "takes.html.j2",
        takes=[(row, _mirrored(patients.get(row.subject), row)) for row in found[:_ON_A_PAGE]],
        found=len(found),
        total=len(rows),
        asked=asked,
        exercises=sorted({row.exercise for row in rows} | ({asked["exercise"]} - {""})),
        patients=patients.values(),
    )


def take(visit: Visit) -> Response:
    """One take: look at it, then approve it."""
    return _take_page(visit)


def approve(visit: Visit) -> Response:
    """Approve exactly this file for play."""
    named = catalogue_id(visit.part("recording"))
    visit.site.clinic.takes.approve(named, visit.account)
    back = "/live" if visit.asked("back") == "live" else f"/takes/{named}"
    sentence = _("Take %(take)s is approved by %(name)s.") % {"take": named, "name": visit.account.name}
    return visit.go(back, sentence)


def withdraw(visit: Visit) -> Response:
    """Take the approval back."""
    named = catalogue_id(visit.part("recording"))
    try:
        visit.site.clinic.approvals.withdraw(named, visit.account, visit.asked("reason"))
    except Refused as refusal:
        return _take_page(visit, str(refusal), "withdraw")
    return visit.go(f"/takes/{named}", _("The approval is withdrawn: this take cannot be played any more."))


def retouch(visit: Visit) -> Response:
    """Make a new take of this one; or show the form again with what is wrong."""
    named = catalogue_id(visit.part("recording"))
    try:
        row = visit.site.clinic.retouching.retouch(
            named, wish_of(visit), visit.asked("reason"), actor=visit.account
        )
    except Refused as refusal:
        return _take_page(visit, str(refusal), "retouch")
    sentence = _("A new take was made. Look at it and compare; nobody has approved it yet.")
    return visit.go(f"/takes/{row.id}/compare", sentence)


def compare(visit: Visit) -> Response:
    """A retouched take over the one that it was made from."""
    takes_of = visit.site.clinic.takes
    row = takes_of.get(catalogue_id(visit.part("recording")))
    if not row.parent:
        raise Refused(f"take {row.id}", "not retouched", "made from another take", "retouch it first")
    before = takes_of.get(row.parent)
    return visit.page(
        "take_compare.html.j2",
        take=row,
        before=before,
        done=done_to(row.retouch),
        figures=(_quality(visit, before), _quality(visit, row)),
    )


def joints(visit: Visit) -> Response:
    """Bending of the joints as a chart; over that of the take it was made from where asked for."""
    takes_of = visit.site.clinic.takes
    row = takes_of.get(catalogue_id(visit.part("recording")))
    before = takes_of.motion(row.parent) if row.parent and visit.part("which") == "compared" else None
    return Response(joint_chart(takes_of.motion(row.id), before), media_type="image/svg+xml")


def _take_page(visit: Visit, sentence: str = "", wrong: str = "") -> Response:
    clinic = visit.site.clinic
    row = clinic.takes.get(catalogue_id(visit.part("recording")))
    return visit.page(
        "take.html.j2",
        status=409 if sentence else 200,
        take=row,
        why_no_names=clinic.marker_names.why_not(row.id),
        quality=_quality(visit, row),
        mirroring=_mirroring(visit, row),
        withdrawal=clinic.approvals.withdrawal(row.id),
        done=done_to(row.retouch),
        children=[one for one in clinic.takes.list() if one.parent == row.id],
        smoothing=SMOOTHING,
        digits=DIGIT_CHOICES,
        asked=plain_form(visit),
        sentence=sentence,
        wrong=wrong,
    )


def _quality(visit: Visit, row: TakeRow) -> TakeQuality | None:
    """Figures of a take, None where its file cannot be read: the page says so."""
    try:
        return quality_of(visit.site.clinic.takes.motion(row.id))
    except Refused:
        return None


def _passes(row: TakeRow, asked: dict[str, str]) -> bool:
    """Whether a take is what the filters ask for; an empty one asks for nothing."""
    approval = "approved" if row.approved_by is not None else "waiting"
    met = {"exercise": row.exercise, "side": row.side, "approval": approval, "patient": row.subject}
    return all(not wanted or wanted == met[name] for name, wanted in asked.items())


def _mirroring(visit: Visit, row: TakeRow) -> Mirroring | None:
    """The patient of the clinic whose own hand was recorded, None where it was somebody else's."""
    if not row.subject:
        return None
    try:
        patient = visit.site.patients.get(row.subject)
    except Refused:
        return None
    return _mirrored(patient, row)


def _mirrored(patient: Patient | None, row: TakeRow) -> Mirroring | None:
    return None if patient is None else Mirroring(patient, patient.side, patient.side != row.side)
