"""What is kept of one patient: consent, a copy to take along, erasure."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

from starlette.background import BackgroundTask
from starlette.responses import FileResponse, Response

from rehab_app.errors import Refused
from rehab_app.web.language import _
from rehab_app.web.pages.patient_tabs import patient_head
from rehab_app.web.pages.typed import sentence_of
from rehab_app.web.visit import Visit


def data(visit: Visit) -> Response:
    """The page."""
    return _page(visit)


def state_consent(visit: Visit) -> Response:
    """Note what the patient says about images."""
    patient, said = visit.part("patient"), visit.asked("given")
    try:
        if said not in ("yes", "no"):
            raise Refused("consent", "not chosen", "given or withdrawn", "choose one")
        visit.site.clinic.privacy.consents.state(visit.account, patient, said == "yes", visit.asked("remark"))
    except Refused as refusal:
        return _page(visit, sentence_of(refusal), 409, "consent")
    return visit.go(f"/patients/{patient}/data", _("The consent is noted."))


def remove_images(visit: Visit) -> Response:
    """Delete the images of the patient's hand."""
    patient = visit.part("patient")
    made = visit.site.clinic.privacy.consents.remove_images(visit.account, patient)
    said = _("%(count)s takes were replaced by takes without images; approve them anew.")
    return visit.go(f"/patients/{patient}/data", said % {"count": len(made)})


def export(visit: Visit) -> Response:
    """Everything as one file; the copy on the server is deleted once it is sent."""
    patient = visit.part("patient")
    handle, name = tempfile.mkstemp(suffix=".zip", prefix=".export-", dir=visit.site.clinic.folder)
    os.close(handle)
    target = Path(name)
    target.unlink()
    visit.site.clinic.privacy.exports.export(visit.account, patient, target)
    return FileResponse(
        target,
        media_type="application/zip",
        filename=f"{patient}.zip",
        background=BackgroundTask(target.unlink, missing_ok=True),
    )


def erase(visit: Visit) -> Response:
    """Erase the patient, once the pseudonym was typed."""
    patient = visit.part("patient")
    try:
        visit.site.clinic.privacy.erasures.erase(visit.account, patient, visit.asked("confirmed"))
    except Refused as refusal:
        return _page(visit, sentence_of(refusal), 409, "erase")
    return visit.go("/patients", _("%(patient)s is erased.") % {"patient": patient})


def _page(visit: Visit, sentence: str = "", status: int = 200, wrong: str = "") -> Response:
    """The page; the form that was refused stands there as it was typed."""
    clinic, patient_id = visit.site.clinic, visit.part("patient")
    patient = clinic.patients.get(patient_id)
    may = visit.account.may("erase")
    return visit.page(
        "patient_data.html.j2",
        status=status,
        head=patient_head(visit, patient, "data"),
        patient=patient,
        agreed=clinic.privacy.consents.given(patient_id),
        history=clinic.privacy.consents.history(patient_id),
        with_images=clinic.privacy.consents.with_images(patient_id),
        found=clinic.privacy.erasures.belongings(visit.account, patient_id) if may else None,
        sentence=sentence,
        wrong=wrong,
        typed={name: visit.asked(name) for name in ("given", "remark", "confirmed")},
    )
