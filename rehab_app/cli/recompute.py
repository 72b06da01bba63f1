"""recompute: measure again what was recorded, where the methods have changed since."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Annotated

import typer

from rehab_app.cli.options import By, Data, Json
from rehab_app.cli.output import Output

if TYPE_CHECKING:
    from rehab_app.services.recompute import Recomputed


def recompute(
    everything: Annotated[bool, typer.Option("--all", help="Every session and take.")] = False,
    session: Annotated[
        list[str] | None,
        typer.Option("--session", metavar="ID", help="This session or take; may be given several times."),
    ] = None,
    metric: Annotated[
        str, typer.Option("--metric", help="Take the digest over this metric alone.", show_default=False)
    ] = "",
    workers: Annotated[
        int | None,
        typer.Option("--workers", min=0, max=256, help="Processes, 0 for all cores.", show_default=False),
    ] = None,
    scheduler: Annotated[
        str | None,
        typer.Option("--scheduler", metavar="URL", help="A Dask scheduler instead.", show_default=False),
    ] = None,
    by: By = "",
    data: Data = None,
    json: Json = False,
) -> None:
    """Measure what has no numbers of this version's methods; broken off, it goes on where it ended."""
    from rehab_app.bootstrap import open_clinic
    from rehab_app.cli.acting import acting
    from rehab_app.cli.progress import frames_bar
    from rehab_app.errors import Refused

    if everything == bool(session):
        value = "--all and --session" if everything else "neither --all nor --session"
        raise Refused("sessions", value, "one of them", "name sessions or ask for all")
    if scheduler and workers is not None:
        raise Refused("--workers", "with --scheduler", "one of them", "leave one out")
    output = Output(json)
    with open_clinic(data) as clinic, frames_bar("Files measured") as told:
        actor = acting(clinic, by)
        files = None if everything else session
        found = clinic.recompute.run(
            actor, files, metric=metric, workers=workers, scheduler=scheduler, told=told
        )
        cells = clinic.norms.renew(actor) if everything else None
    _tell(output, found)
    if cells is not None:
        output.say(f"Norms of this clinic: {len(cells)} groups of patients.")
    output.result(asdict(found) | ({} if cells is None else {"norms": len(cells)}))
    if found.troubles:
        raise typer.Exit(1)


def _tell(output: Output, found: Recomputed) -> None:
    output.say(f"{found.files} files: {found.kept} were measured already, {found.measured} are now.")
    for trouble in found.troubles:
        output.say(f"Not measured: {trouble.id}, {trouble.reason}")
    output.say(f"Digest: {found.digest}")
