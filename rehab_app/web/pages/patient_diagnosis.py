"""The clinical record of a patient: state it, see what it locks, unlock and lock modes."""

from __future__ import annotations

import json
from dataclasses import fields, replace

from starlette.responses import Response

from rehab_app.errors import REFUSALS, Refused
from rehab_app.services.clinical import bones_of
from rehab_app.services.diagnosis import precautions
from rehab_app.services.diagnosis_templates import TEMPLATES
from rehab_app.web.language import _, written
from rehab_app.web.pages import patient_words as words
from rehab_app.web.pages.asked import decimal
from rehab_app.web.pages.patient_tabs import patient_head
from rehab_app.web.pages.typed import Typed, sentence_of
from rehab_app.web.render import mode
from rehab_app.web.visit import Visit
from robot_iface.types import DIGITS
from sessions.catalogue import MAS_GRADES, ClinicalRecord, Patient

_BONES = 3
_FLAGS = ("insensate", "unaware", "rheumatoid", "crps", "hyperextension_allowed")
BONES = tuple(f"{digit}_{number}" for digit in DIGITS for number in range(1, _BONES + 1))
_NAMES = ("diagnosis", "event_date", "mas", *_FLAGS, *BONES)
_THINGS = {
    "diagnosis": "diagnosis",
    "event date": "event_date",
    "Modified Ashworth grade": "mas",
    "bone lengths": "thumb_1",
}


def diagnosis(visit: Visit) -> Response:
    """What is known of the hand, and what follows from it."""
    patient = visit.site.clinic.patients.get(visit.part("patient"))
    form = Typed(visit, ())
    form.values = _shown(visit.site.clinic.clinical.record(patient.id))
    return _page(visit, patient, form, ())


def state_record(visit: Visit) -> Response:
    """State it anew; where somebody else did so meanwhile, show both."""
    clinical = visit.site.clinic.clinical
    patient = visit.site.clinic.patients.get(visit.part("patient"))
    form = Typed(visit, _NAMES)
    bones = _bones(form)
    since = visit.asked("since")
    read = int(since) if since.isascii() and since.isdecimal() and len(since) < 10 else 0
    try:
        asked = ClinicalRecord(
            patient=patient.id,
            diagnosis=form.values["diagnosis"],
            event_date=form.values["event_date"],
            mas=form.values["mas"],
            bones_m=bones,
            by=visit.account.name,
        )
        asked = replace(asked, **{name: form.values[name] == "yes" for name in _FLAGS})
        if not form.problems:
            kept = clinical.state(visit.account, asked, since=read)
            said = _("The clinical record is stated: version %(number)s.") % {"number": kept.id}
            return visit.go(f"/patients/{patient.id}/diagnosis", said)
    except REFUSALS as refusal:
        newest = clinical.record(patient.id)
        if newest is None or newest.id == read:
            form.refuse(refusal, _THINGS)
    return _page(visit, patient, form, _differences(form, clinical.record(patient.id), read))


def unlock(visit: Visit) -> Response:
    """Let a locked mode be used: a therapist's act with a reason."""
    clinical, named = visit.site.clinic.clinical, visit.part("patient")
    patient, chosen, reason = (
        visit.site.clinic.patients.get(named),
        visit.asked("mode"),
        visit.asked("reason"),
    )
    try:
        kept = clinical.unlock(visit.account, named, chosen, reason)
    except REFUSALS as refusal:
        form = Typed(visit, ())
        form.values = _shown(clinical.record(named)) | {"mode": chosen, "reason": reason}
        form.refuse(refusal, {refusal.thing: f"reason_{chosen}"})
        return _page(visit, patient, form, ())
    said = _("%(mode)s is unlocked by %(name)s.") % {"mode": mode(kept.mode), "name": kept.by}
    return visit.go(f"/patients/{named}/diagnosis", said)


def lock(visit: Visit) -> Response:
    """Take an unlock back: anybody may, it is the safer way."""
    back = f"/patients/{visit.part('patient')}/diagnosis"
    try:
        kept = visit.site.clinic.clinical.lock(visit.account, visit.part("patient"), visit.asked("mode"))
    except REFUSALS as refusal:
        return visit.go(back, sentence_of(refusal), good=False)
    return visit.go(back, _("%(mode)s is locked again.") % {"mode": mode(kept.mode)})


def _page(visit: Visit, patient: Patient, form: Typed, changed: tuple[tuple[str, str, str], ...]) -> Response:
    clinical = visit.site.clinic.clinical
    records = clinical.records(patient.id)
    return visit.page(
        "patient_diagnosis.html.j2",
        status=409 if form.problems or changed else 200,
        head=patient_head(visit, patient, "diagnosis"),
        patient=patient,
        record=next(iter(records), None),
        records=records,
        cautions=precautions(next(iter(records), None)),
        locks=clinical.mode_locks(patient.id),
        templates=TEMPLATES,
        grades=MAS_GRADES,
        digits=DIGITS,
        bones=BONES,
        asked={"mode": "", "reason": ""} | form.values,
        problems=form.problems,
        changed=changed,
        words=words,
    )


def _shown(record: ClinicalRecord | None) -> dict[str, str]:
    """A record as the form shows it; nothing is known without one."""
    values = dict.fromkeys(_NAMES, "")
    if record is None:
        return values
    values |= {"diagnosis": record.diagnosis, "event_date": record.event_date, "mas": record.mas}
    values |= {name: "yes" if getattr(record, name) else "" for name in _FLAGS}
    lengths_m = [length_m for row in bones_of(record) for length_m in row]
    return values | {name: written(round(1e3 * one, 1)) for name, one in zip(BONES, lengths_m, strict=False)}


def _bones(form: Typed) -> str:
    """Measured bones as the record keeps them, typed in mm; empty where no field is filled in."""
    if not any(form.values[name] for name in BONES):
        return ""
    lengths_m = [form.read(name, _millimetres, 0.02) for name in BONES]
    return json.dumps([lengths_m[start : start + _BONES] for start in range(0, len(BONES), _BONES)])


def _millimetres(text: str) -> float:
    length_m = decimal(text) / 1e3
    if not 0.008 <= length_m <= 0.08:
        raise Refused("bone", repr(text[:40]) if text else "empty", "8 to 80 mm", "measure it, or empty all")
    return length_m


def _differences(form: Typed, now: ClinicalRecord | None, read: int) -> tuple[tuple[str, str, str], ...]:
    """Field, what was typed, what stands there now: where somebody stated a version since the one read."""
    if now is None or now.id == read:
        return ()
    theirs = _shown(now)
    known = {item.name for item in fields(now)}
    differing = [name for name in _NAMES if form.values[name] != theirs[name]]
    found = [(name, form.values[name], theirs[name]) for name in differing if name in known]
    if any(name in BONES for name in differing):
        yours, there = (" ".join(values[name] or "-" for name in BONES) for values in (form.values, theirs))
        found.append(("bones_m", yours, there))
    return tuple(found)
