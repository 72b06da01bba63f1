"""progress: a patient over all sessions, and two sessions beside each other."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rehab_app.cli.options import Data, Json, PatientId
from rehab_app.cli.output import Output


def progress(
    patient: PatientId,
    compare: Annotated[
        str,
        typer.Option(
            "--compare", help="Two session ids with a comma: report these two instead.", show_default=False
        ),
    ] = "",
    formats: Annotated[
        str, typer.Option("--format", help="html, pdf, csv, json, note; several with a comma.")
    ] = "html",
    out: Annotated[
        Path | None, typer.Option("--out", help="Folder, or file for one format.", show_default=False)
    ] = None,
    language: Annotated[
        str, typer.Option("--language", help="Language of html, pdf and note: en or it.")
    ] = "en",
    data: Data = None,
    json: Json = False,
) -> None:
    """Report a patient's progress over all sessions, or compare two."""
    from rehab_app.access import CONSOLE
    from rehab_app.bootstrap import open_clinic
    from rehab_app.errors import Refused
    from sessions.reports.progress_formats import progress_object

    output = Output(json)
    wanted = [name.strip() for name in formats.split(",") if name.strip()]
    pair = [name.strip() for name in compare.split(",") if name.strip()]
    if len(pair) not in (0, 2):
        raise Refused("--compare", repr(compare), "two session ids with a comma", "name two")
    with open_clinic(data) as clinic:
        known = clinic.patients.get(patient)
        if pair:
            found = clinic.progress.comparison(*pair)
            if found.subject_id != known.id:
                raise Refused("comparison", f"of {found.subject_id}", f"of {known.id}", "name their sessions")
        else:
            found = clinic.progress.of_patient(known.id, output.say)
        made = clinic.progress.write(found, wanted, out, CONSOLE, language)
    for path in made:
        output.say(f"Progress: {path}")
    output.result({**progress_object(found), "files": list(made)})
