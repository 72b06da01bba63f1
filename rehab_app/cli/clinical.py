"""Clinical records of patients: diagnosis, precautions, locked modes."""

from __future__ import annotations

import json as jsonlib
import math
from dataclasses import asdict
from typing import TYPE_CHECKING, Annotated, Any, TypeAlias

import typer

from rehab_app.cli.options import By, Data, Json, PatientId
from rehab_app.cli.output import Output
from rehab_app.cli.people import patient

if TYPE_CHECKING:
    from sessions.catalogue import ClinicalRecord

__all__ = ["patient"]

LockedMode: TypeAlias = Annotated[str, typer.Option("--mode", help="Therapy mode.")]


@patient.command("record")
def state_record(
    patient_id: PatientId,
    diagnosis: Annotated[str, typer.Option("--diagnosis", help="Template, see `patient diagnoses`.")],
    event_date: Annotated[
        str, typer.Option("--event-date", help="Date of the stroke, injury or operation, as 2026-12-31.")
    ] = "",
    mas: Annotated[str, typer.Option("--mas", help="Modified Ashworth grade: 0, 1, 1+, 2, 3 or 4.")] = "",
    insensate: Annotated[bool, typer.Option("--insensate", help="The skin does not feel.")] = False,
    unaware: Annotated[bool, typer.Option("--unaware", help="Neglect or aphasia.")] = False,
    rheumatoid: Annotated[bool, typer.Option("--rheumatoid", help="Rheumatoid arthritis.")] = False,
    crps: Annotated[bool, typer.Option("--crps", help="Complex regional pain syndrome.")] = False,
    hyperextension: Annotated[
        bool, typer.Option("--allow-hyperextension", help="Flexion joints may go below 0 degrees.")
    ] = False,
    bones_mm: Annotated[
        str,
        typer.Option("--bones-mm", help="15 lengths with commas: thumb to little, each from the palm out."),
    ] = "",
    by: By = "",
    data: Data = None,
    json: Json = False,
) -> None:
    """State what therapy must know of a patient's hand; the newest statement counts."""
    from rehab_app.bootstrap import open_clinic
    from rehab_app.cli.acting import acting
    from sessions.catalogue import ClinicalRecord

    output = Output(json)
    with open_clinic(data) as clinic:
        actor = acting(clinic, by)
        asked = ClinicalRecord(
            patient=patient_id,
            diagnosis=diagnosis,
            event_date=event_date,
            mas=mas,
            insensate=insensate,
            unaware=unaware,
            rheumatoid=rheumatoid,
            crps=crps,
            hyperextension_allowed=hyperextension,
            bones_m=_bones(bones_mm),
            by=actor.name,
        )
        kept = clinic.clinical.state(actor, asked)
        locks = clinic.clinical.locks(patient_id)
    output.say(f"The clinical record of {kept.patient} is version {kept.id}.")
    _tell_record(output, kept, locks)


@patient.command("show")
def show_patient(patient_id: PatientId, data: Data = None, json: Json = False) -> None:
    """Show a patient's clinical record and what it locks today."""
    from rehab_app.bootstrap import open_clinic
    from rehab_app.services.wearer import identity_of

    output = Output(json)
    with open_clinic(data) as clinic:
        output.say(f"{identity_of(clinic.patients.get(patient_id))}")
        record = clinic.clinical.record(patient_id)
        locks = clinic.clinical.locks(patient_id)
    if record is None:
        output.say("Nobody has stated a clinical record: no precaution holds. Use `patient record`.")
        output.result({"patient": patient_id, "record": None, "locks": {}})
    else:
        _tell_record(output, record, locks)


@patient.command("unlock")
def unlock(
    patient_id: PatientId,
    mode: LockedMode,
    reason: Annotated[str, typer.Option("--reason", help="Why it may be used before its date.")],
    by: By = "",
    data: Data = None,
    json: Json = False,
) -> None:
    """Let a locked mode be used: a therapist's act, kept with name and reason."""
    from rehab_app.bootstrap import open_clinic
    from rehab_app.cli.acting import acting

    output = Output(json)
    with open_clinic(data) as clinic:
        kept = clinic.clinical.unlock(acting(clinic, by), patient_id, mode, reason)
    output.say(f"{kept.mode} mode of {kept.patient} is unlocked by {kept.by}.")
    output.result(asdict(kept))


@patient.command("lock")
def lock(patient_id: PatientId, mode: LockedMode, by: By = "", data: Data = None, json: Json = False) -> None:
    """Take an unlock back."""
    from rehab_app.bootstrap import open_clinic
    from rehab_app.cli.acting import acting

    output = Output(json)
    with open_clinic(data) as clinic:
        kept = clinic.clinical.lock(acting(clinic, by), patient_id, mode)
    output.say(f"{kept.mode} mode of {kept.patient} is locked again.")
    output.result(asdict(kept))


@patient.command("diagnoses")
def diagnoses(data: Data = None, json: Json = False) -> None:
    """List the diagnosis templates with their locks; all are proposals for a clinician to sign."""
    del data  # every command takes it; this one touches no clinic folder
    from rehab_app.services.diagnosis_templates import BY_ACT_ONLY, TEMPLATES

    output = Output(json)
    rows: list[dict[str, Any]] = []
    for one in TEMPLATES:
        days = {lock.mode: None if lock.from_day == BY_ACT_ONLY else lock.from_day for lock in one.locks}
        said = [
            f"{mode} " + ("by a therapist's act only" if day is None else f"from day {day:.0f}")
            for mode, day in days.items()
        ]
        output.say(f"{one.key}: {', '.join(said) or 'nothing is locked'}")
        rows.append(
            {
                "key": one.key,
                "words": one.words,
                "event": one.event,
                "locked_until_day": days,
                "torque_halved": one.halved,
                "skin_check_s": one.skin_check_s,
            }
        )
    output.result({"diagnoses": rows})


def _tell_record(output: Output, record: ClinicalRecord, locks: dict[str, str]) -> None:
    from rehab_app.services.diagnosis import precautions

    cautions = precautions(record)
    output.say(f"{record.diagnosis}, event {record.event_date or 'undated'}, stated by {record.by}.")
    for sentence in (*cautions.notes, *locks.values()):
        output.say(sentence)
    content = {**asdict(record), "bones_m": jsonlib.loads(record.bones_m or "[]")}
    output.result({"patient": record.patient, "record": content, "locks": locks, "notes": cautions.notes})


def _bones(text: str) -> str:
    """Bone lengths typed in mm as the record keeps them; empty for none.

    Raises:
        Refused: They are not fifteen finite numbers.
    """
    from rehab_app.errors import Refused

    if not text:
        return ""
    try:
        lengths = [float(part) / 1e3 for part in text.split(",")]
    except ValueError:
        lengths = []
    for place, length in enumerate(lengths, start=1):
        if not math.isfinite(length):
            raise Refused("--bones-mm", f"no length in place {place}", "a length in mm", "measure this bone")
    if len(lengths) != 15:
        raise Refused("--bones-mm", repr(text[:60]), "15 numbers with commas", "measure five digits of three")
    return jsonlib.dumps([lengths[start : start + 3] for start in range(0, 15, 3)])
