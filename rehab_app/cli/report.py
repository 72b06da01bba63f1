"""report: numbers of sessions and takes in every format, and the proof that a report is its file's."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from rehab_app.cli.options import Data, Json
from rehab_app.cli.output import Output


def report(
    sessions: Annotated[
        list[str], typer.Argument(metavar="SESSION...", help="Paths or catalogue ids of sessions or takes.")
    ],
    formats: Annotated[
        str, typer.Option("--format", help="html, pdf, csv, parquet, fhir, json, note; several with a comma.")
    ] = "html,json",
    out: Annotated[
        Path | None, typer.Option("--out", help="Folder, or file for one format.", show_default=False)
    ] = None,
    verify: Annotated[
        Path | None,
        typer.Option("--verify", help="A report (JSON): make it again from SESSION.", show_default=False),
    ] = None,
    language: Annotated[
        str, typer.Option("--language", help="Language of html, pdf and note: en or it.")
    ] = "en",
    data: Data = None,
    json: Json = False,
) -> None:
    """Report sessions or takes, or prove that a report is what its file gives."""
    import msgspec

    from rehab_app.access import CONSOLE
    from rehab_app.bootstrap import open_clinic

    output = Output(json)
    if verify is not None:
        _verify(verify, sessions, data, output)
        return
    wanted = [name.strip() for name in formats.split(",") if name.strip()]
    with open_clinic(data) as clinic:
        made = clinic.reports.report(sessions, wanted, out, actor=CONSOLE, language=language)
        content: dict[str, Any] = msgspec.json.decode(clinic.reports.json(*sessions)) if json else {}
    for path in made:
        output.say(f"Report: {path}")
    output.result({**content, "files": list(made)})


def _verify(report_json: Path, sessions: list[str], data: Path | None, output: Output) -> None:
    """Make every number of a report again; the first that differs is refused."""
    from rehab_app.cli.locate import locate
    from rehab_app.errors import Refused
    from sessions.reports.recompute import verify_report

    if len(sessions) != 1:
        raise Refused(
            "--verify", f"given {len(sessions)} sessions", "given one", "name the one that is meant"
        )
    proof = verify_report(report_json, locate(sessions[0], data))
    output.say(f"All {proof.numbers} numbers of {report_json.name} are what the file gives, bit for bit.")
    output.result({"ok": True, "numbers": proof.numbers, "sha256": proof.file_sha256})
