"""Takes: the list with its filters, one take to look at, approve, withdraw, retouch and compare."""

from __future__ import annotations

from dataclasses import dataclass
from urllib.parse import urlencode

from starlette.responses import Response

from rehab_app.errors import Refused
from rehab_app.services.rows import TakeRow
from rehab_app.services.take_chart import joint_chart
from rehab_app.services.take_quality import TakeQuality, quality_of
from rehab_app.web.language import _
from rehab_app.web.pages.choices import take_words
from rehab_app.web.pages.recordings import catalogue_id
from rehab_app.web.pages.retouch_form import DIGIT_CHOICES, SMOOTHING, done_to, plain_form, wish_of
from rehab_app.web.visit import Visit
from sessions.catalogue import Patient, TakeFilter

_FILTERS = ("find", "exercise", "side", "approval", "patient")
_APPROVAL = {"approved": True, "waiting": False}


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
    """Takes, the newest first, those that the filters let through, page by page."""
    shelf, query = visit.site.clinic.takes.shelf, visit.request.query_params
    asked = {name: query.get(name, "").strip()[:160] for name in _FILTERS}
    number = query.get("page", "1")
    page = int(number) if number.isascii() and number.isdecimal() and len(number) < 7 else 1
    found, counts = shelf.find(_wanted(visit, asked), page), shelf.counts()
    people = shelf.people(found.takes)

    def link(page: int) -> str:
        values = {**asked, "page": str(page) if page > 1 else ""}
        return "/takes?" + urlencode({name: value for name, value in values.items() if value})

    return visit.page(
        "takes.html.j2",
        takes=[(row, _mirrored(people.get(row.subject), row)) for row in found.takes],
        found=found,
        total=sum(counts.values()),
        asked=asked,
        link=link,
        exercises=sorted({*counts} | ({asked["exercise"]} - {""})),
        patients=_hands(visit, asked["patient"]),
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
        children=clinic.takes.shelf.find(TakeFilter(parent=row.id)).takes,
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


def _wanted(visit: Visit, asked: dict[str, str]) -> TakeFilter:
    """What the filters ask for; an empty one asks for nothing."""
    return TakeFilter(
        exercise=asked["exercise"],
        side=asked["side"],
        approved=_APPROVAL.get(asked["approval"]),
        subject=asked["patient"],
        words=take_words(visit, asked["find"]),
    )


def _hands(visit: Visit, chosen: str) -> tuple[Patient, ...]:
    """Whose hands can be filtered for: everybody where they are few, else the one who is chosen already."""
    few = visit.site.clinic.takes.shelf.demonstrators()
    if few or not chosen:
        return few
    return visit.site.clinic.catalogue.patients_named((chosen,))


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
