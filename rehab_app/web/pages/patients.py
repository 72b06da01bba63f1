"""Patients: the list, a new one, changes to who somebody is."""

from __future__ import annotations

from dataclasses import replace
from urllib.parse import urlencode

from starlette.responses import Response

from rehab_app.errors import Refused
from rehab_app.web.language import _
from rehab_app.web.pages.first_steps import first_steps
from rehab_app.web.pages.patient_fields import THINGS, Difference, empty, merge, shown, typed_patient
from rehab_app.web.pages.patient_tabs import patient_head
from rehab_app.web.pages.patient_words import FIELDS
from rehab_app.web.pages.typed import Typed
from rehab_app.web.visit import Visit
from sessions.catalogue import Patient


def patients(visit: Visit) -> Response:
    """Patients by words of their name, birth date or pseudonym; the archived ones on demand."""
    asked = visit.request.query_params
    typed, order = asked.get("find", "").strip(), asked.get("order", "name")
    archived = asked.get("archived", "") == "yes"
    page = asked.get("page", "1")
    number = int(page) if page.isascii() and page.isdecimal() and len(page) < 7 else 1
    found = visit.site.clinic.patients.search(typed, archived=archived, order=order, page=number)

    def link(**changed: object) -> str:
        values = {"find": typed, "order": order, "archived": "yes" if archived else "", "page": ""} | changed
        return "/patients?" + urlencode({name: value for name, value in values.items() if value})

    return visit.page(
        "patients.html.j2",
        found=found,
        typed=typed,
        order=order,
        archived=archived,
        link=link,
        first=first_steps(visit),
    )


def new_patient(visit: Visit) -> Response:
    """The form of a new patient."""
    return visit.page("new_patient.html.j2", asked=empty(), problems={}, namesakes=(), words=FIELDS)


def add_patient(visit: Visit) -> Response:
    """Add a patient, or show the form again with what is wrong, or with those who could be meant."""
    form, wanted = typed_patient(visit)
    names = (wanted.given_name, wanted.family_name, wanted.birth_date)
    known = () if form.problems else visit.site.clinic.patients.namesakes(*names)
    unseen = {one.id for one in known} - set(visit.asked("others").split())
    if form.problems or unseen:
        return _new_again(visit, form, known)
    try:
        added = visit.site.clinic.patients.add(
            visit.account,
            given_name=wanted.given_name,
            family_name=wanted.family_name,
            birth_date=wanted.birth_date,
            side=wanted.side,
            hand_length_m=wanted.hand_length_m,
            impairment=wanted.impairment,
        )
    except Refused as refusal:
        form.refuse(refusal, THINGS)
        return _new_again(visit, form, ())
    said = _("%(name)s was added.") % {"name": f"{added.given_name} {added.family_name}"}
    return visit.go(f"/patients/{added.id}", said)


def edit_patient(visit: Visit) -> Response:
    """The form with a patient in it."""
    patient = visit.site.clinic.patients.get(visit.part("patient"))
    form = Typed(visit, ())
    form.values = shown(patient)
    return _edit(visit, patient, form, ())


def change_patient(visit: Visit) -> Response:
    """Save it; where somebody else saved first, show both, so that neither text is lost."""
    patients = visit.site.clinic.patients
    now = patients.get(visit.part("patient"))
    form, wanted = typed_patient(visit)
    changed = merge(form, visit, now) if wanted.version != now.version else ()
    if changed or form.problems:
        return _edit(visit, now, form, changed)
    try:  # where nothing was changed that this form holds, only the version is another
        patients.change(visit.account, replace(wanted, id=now.id, version=now.version))
    except Refused as refusal:
        newer = patients.get(now.id)
        if newer.version == now.version:
            form.refuse(refusal, THINGS)
        return _edit(visit, newer, form, merge(form, visit, newer))
    visit.site.patients.forget(now.id)
    return visit.go(f"/patients/{now.id}", _("The changes are saved."))


def archive(visit: Visit) -> Response:
    """Take a patient out of the lists."""
    kept = visit.site.clinic.patients.archive(visit.account, visit.part("patient"))
    return visit.go(f"/patients/{kept.id}", _("Archived: no longer in the list. Nothing is lost."))


def unarchive(visit: Visit) -> Response:
    """Put a patient back into the lists."""
    kept = visit.site.clinic.patients.unarchive(visit.account, visit.part("patient"))
    return visit.go(f"/patients/{kept.id}", _("Back in the list."))


def _new_again(visit: Visit, form: Typed, namesakes: tuple[Patient, ...]) -> Response:
    return visit.page(
        "new_patient.html.j2",
        status=409,
        asked=form.values,
        problems=form.problems,
        namesakes=namesakes,
        words=FIELDS,
    )


def _edit(visit: Visit, now: Patient, form: Typed, changed: tuple[Difference, ...]) -> Response:
    """The form; a conflict says who saved meanwhile and shows both texts."""
    return visit.page(
        "patient_edit.html.j2",
        status=409 if form.problems or changed else 200,
        head=patient_head(visit, now, "edit"),
        asked=form.values,
        was=shown(now),
        problems=form.problems,
        changed=changed,
        changed_by=visit.site.clinic.patients.last_change(now.id) if changed else None,
        words=FIELDS,
    )
