"""Privacy: backup, restore, export and erasure of one patient, retention, consent."""

from __future__ import annotations

import os
import sys
from dataclasses import asdict
from pathlib import Path
from typing import Annotated, TypeAlias

import typer

from rehab_app.cli.options import By, Data, Json, PatientId
from rehab_app.cli.output import Output
from rehab_app.cli.people import patient
from rehab_app.cli.refusals import Commands

ENVIRONMENT = "REHAB_BACKUP_PASSPHRASE"
PassphraseFile: TypeAlias = Annotated[
    Path | None,
    typer.Option(
        "--passphrase-file",
        help=f"File whose first line is the passphrase (else {ENVIRONMENT}, else it is asked for).",
        show_default=False,
    ),
]
retention = typer.Typer(cls=Commands, help="How long patients are kept.", no_args_is_help=True)


def backup(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="New file, outside the clinic folder.")],
    passphrase_file: PassphraseFile = None,
    new_passphrase: Annotated[
        bool, typer.Option("--new-passphrase", help="Set another passphrase for this and later backups.")
    ] = False,
    by: By = "",
    data: Data = None,
    json: Json = False,
) -> None:
    """Back the whole clinic up into one encrypted file, while it works.

    The passphrase is asked for once, by the first backup; later ones need none. Restoring needs it.
    """
    from rehab_app.bootstrap import open_clinic
    from rehab_app.cli.acting import acting

    output = Output(json)
    with open_clinic(data) as clinic:
        actor, backups = acting(clinic, by), clinic.privacy.backups
        if new_passphrase or backups.key() is None:
            backups.set_passphrase(actor, _passphrase(passphrase_file, confirm=True))
        made = backups.make(actor, file)
    output.say(f"Backed up: {made.files} files, {made.bytes / 1e6:.1f} MB, {file}. Keep the passphrase safe.")
    output.result({"backup": file, **asdict(made)})


def restore(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A backup.")],
    passphrase_file: PassphraseFile = None,
    data: Data = None,
    json: Json = False,
) -> None:
    """Restore a backup into a new clinic folder; who was erased since then is erased again."""
    from rehab_app.config import resolve_folder
    from rehab_app.services.restoring import restore as unpack

    output = Output(json)
    made = unpack(file, resolve_folder(data), _passphrase(passphrase_file, confirm=False))
    files, rows = len(made.manifest.sha256), made.audit_rows
    output.say(f"Restored {files} files into {made.folder}; the audit of {rows} rows is whole.")
    for one in made.erased_again:
        output.say(f"{one} had been erased after this backup and was erased again.")
    again = list(made.erased_again)
    output.result({"folder": made.folder, "files": files, "audit_rows": rows, "erased_again": again})


def export(
    patient_id: PatientId,
    out: Annotated[Path, typer.Option("--out", help="New .zip file.")],
    by: By = "",
    data: Data = None,
    json: Json = False,
) -> None:
    """Write everything that is kept about one patient into one file."""
    from rehab_app.bootstrap import open_clinic
    from rehab_app.cli.acting import acting

    output = Output(json)
    with open_clinic(data) as clinic:
        names = clinic.privacy.exports.export(acting(clinic, by), patient_id, out)
    output.say(f"Exported {len(names)} files to {out}. identity.json in it holds the name: keep it safe.")
    output.result({"export": out, "files": list(names)})


@patient.command("erase")
def erase(
    patient_id: PatientId,
    confirmed: Annotated[
        str, typer.Option("--confirm", help="The pseudonym once more; else it is asked for.")
    ] = "",
    by: By = "",
    data: Data = None,
    json: Json = False,
) -> None:
    """Erase one patient for good: record, sessions, reports, and takes of the patient's own hand."""
    from rehab_app.bootstrap import open_clinic
    from rehab_app.cli.acting import acting

    output = Output(json)
    with open_clinic(data) as clinic:
        actor, erasures = acting(clinic, by), clinic.privacy.erasures
        found = erasures.belongings(actor, patient_id)
        output.say(
            f"{patient_id}: {len(found.sessions)} sessions and {len(found.takes)} takes will go, with every "
            f"entry; {len(found.shared_takes)} takes that others use lose their link to the patient."
        )
        if not confirmed and sys.stdin.isatty():
            confirmed = str(typer.prompt(f"Type {patient_id} to erase for good", err=True))
        erasures.erase(actor, patient_id, confirmed)
    output.say(f"{patient_id} is erased. Backups made before still hold the patient until they are restored.")
    output.result(
        {"patient": patient_id, "sessions": len(found.sessions), "takes": len(found.takes), "erased": True}
    )


@patient.command("consent")
def consent(
    patient_id: PatientId,
    given: Annotated[bool | None, typer.Option("--given/--withdrawn", help="What the patient says.")] = None,
    remark: Annotated[str, typer.Option("--remark", help="How it was said; never a name.")] = "",
    remove_images: Annotated[
        bool, typer.Option("--remove-images", help="Delete images of the patient's hand from stored takes.")
    ] = False,
    by: By = "",
    data: Data = None,
    json: Json = False,
) -> None:
    """Note the consent to stored images, or show it."""
    from rehab_app.bootstrap import open_clinic
    from rehab_app.cli.acting import acting

    output = Output(json)
    with open_clinic(data) as clinic:
        actor, consents = acting(clinic, by), clinic.privacy.consents
        if given is not None:
            consents.state(actor, patient_id, given, remark)
        made = consents.remove_images(actor, patient_id) if remove_images else ()
        history, held = consents.history(patient_id), consents.with_images(patient_id)
        agreed = consents.given(patient_id)
    words = "agrees to stored images" if agreed else "has not agreed to stored images"
    output.say(f"{patient_id} {words}; {len(held)} takes of this hand hold images.")
    output.result(
        {
            "patient": patient_id,
            "given": agreed,
            "with_images": list(held),
            "replaced_by": list(made),
            "history": [asdict(row) for row in history],
        }
    )


@retention.command("show")
def show_retention(data: Data = None, json: Json = False) -> None:
    """Say how long patients are kept and who is due."""
    from rehab_app.bootstrap import open_clinic

    output = Output(json)
    with open_clinic(data) as clinic:
        years, due = clinic.privacy.retention.years(), clinic.privacy.retention.due()
    kept = f"{years} years after the last entry" if years else "until somebody erases them"
    output.say(f"Patients are kept {kept}; {len(due)} are due.")
    for one in due:
        output.say(f"{one}: erase with rehab-app patient erase {one}")
    output.result({"years": years, "due": list(due)})


@retention.command("set")
def set_retention(
    years: Annotated[int, typer.Argument(metavar="YEARS", help="0 keeps everything.")],
    by: By = "",
    data: Data = None,
    json: Json = False,
) -> None:
    """Change how long patients are kept; nothing is erased by itself."""
    from rehab_app.bootstrap import open_clinic
    from rehab_app.cli.acting import acting

    output = Output(json)
    with open_clinic(data) as clinic:
        clinic.privacy.retention.set_years(acting(clinic, by), years)
    output.say(f"Patients are kept {years} years after the last entry." if years else "Patients are kept.")
    output.result({"years": years})


def _passphrase(file: Path | None, confirm: bool) -> str:
    """From a file, the environment or the terminal; never from an argument, which others may see."""
    if file is not None:
        return (file.read_text(encoding="utf-8").splitlines() or [""])[0]
    if named := os.environ.get(ENVIRONMENT, ""):
        return named
    if not sys.stdin.isatty():
        return sys.stdin.readline().rstrip("\n")
    return str(typer.prompt("Backup passphrase", hide_input=True, confirmation_prompt=confirm, err=True))
