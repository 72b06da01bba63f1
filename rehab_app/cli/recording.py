"""Motion in: import, record, approve."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from rehab_app.cli.options import Data, Json, Out, Seed, Side, Take
from rehab_app.cli.output import Output

if TYPE_CHECKING:
    from rehab_app.services.rows import ImportedSummary


def import_(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="Qualisys TSV or MediaPipe landmark .npz.")],
    side: Side = "right",
    protocol: Annotated[
        str | None, typer.Option("--protocol", help="Marker protocol, by name or TOML file.")
    ] = None,
    out: Out = None,
    data: Data = None,
    json: Json = False,
) -> None:
    """Turn a recording of another program into a take."""
    from rehab_app.access import CONSOLE
    from rehab_app.bootstrap import open_clinic

    output = Output(json)
    with open_clinic(data) as clinic:
        summary = clinic.takes.import_file(file, side=side, protocol=protocol, actor=CONSOLE, out=out)
    _tell(output, summary)


def record(
    exercise: Annotated[str, typer.Option("--exercise", help="Movement to show.")] = "open_close",
    side: Side = "right",
    seconds: Annotated[float, typer.Option("--seconds", help="Length, s.")] = 8.0,
    seed: Seed = 1,
    out: Out = None,
    data: Data = None,
    json: Json = False,
) -> None:
    """Record a take from the virtual camera."""
    from rehab_app.access import CONSOLE
    from rehab_app.bootstrap import open_clinic

    output = Output(json)
    with open_clinic(data) as clinic:
        summary = clinic.takes.record_virtual(exercise, side, seconds, seed, CONSOLE, out)
    _tell(output, summary)


def approve(
    take: Take,
    by: Annotated[str, typer.Option("--by", help="Who approves.")],
    data: Data = None,
    json: Json = False,
) -> None:
    """Approve a take; ``play`` refuses those that nobody approved."""
    from rehab_app.bootstrap import open_clinic

    output = Output(json)
    with open_clinic(data) as clinic:
        approver = clinic.accounts.at_console(by)
        row = clinic.takes.get(take)
        clinic.takes.approve(row.id, approver)
    output.say(f"Take {row.id} is approved by {by}.")
    output.result({"take": row.path, "id": row.id, "by": by, "sha256": row.sha256})


def summary_json(summary: ImportedSummary) -> dict[str, Any]:
    """A new take, as JSON: ``take`` is its path."""
    return {
        "take": summary.path,
        "id": summary.take,
        "duration_s": summary.duration_s,
        "landmarks": summary.landmarks,
        "frames": summary.frames,
        "gaps": summary.gaps,
    }


def _tell(output: Output, summary: ImportedSummary) -> None:
    output.say(
        f"Take {summary.take}: {summary.duration_s:.1f} s, {summary.frames} frames of {summary.landmarks} "
        f"landmarks, {summary.gaps} gaps. It lies in {summary.path}."
    )
    output.say(f"Approve it with: rehab-app approve {summary.take} --by NAME")
    output.result(summary_json(summary))
