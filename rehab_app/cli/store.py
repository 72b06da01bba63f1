"""The object store: how it stands, send now, make room, bring back."""

from __future__ import annotations

from dataclasses import asdict
from typing import Annotated

import typer

from rehab_app.cli.options import By, Data, Json
from rehab_app.cli.output import Output
from rehab_app.cli.refusals import Commands

store = typer.Typer(cls=Commands, help="Sealed recordings in an object store.", no_args_is_help=True)


@store.command("status")
def status(data: Data = None, json: Json = False) -> None:
    """Say what waits for the object store, and why."""
    from rehab_app.bootstrap import open_clinic

    output = Output(json)
    with open_clinic(data) as clinic:
        stands = clinic.uploads.status()
    if not stands.bucket:
        output.say("There is no object store: recordings stay in the clinic folder (store.bucket is empty).")
    else:
        output.say(
            f"Bucket {stands.bucket}: {stands.stored} files proven there, {stands.to_send} wait to be sent, "
            f"{stands.to_delete} to be deleted."
        )
    if stands.trouble:
        output.say(f"The last try did not finish: {stands.trouble}")
    output.result(asdict(stands))


@store.command("push")
def push(by: By = "", data: Data = None, json: Json = False) -> None:
    """Send what waits now, and prove it."""
    from rehab_app.bootstrap import open_clinic
    from rehab_app.cli.acting import acting

    output = Output(json)
    with open_clinic(data) as clinic:
        done = clinic.uploads.push(acting(clinic, by))
    output.say(f"Sent {done.sent} files, deleted {done.deleted} objects; {done.waiting} wait.")
    for sentence in done.refused:
        output.say(sentence)
    output.result(asdict(done))
    if done.refused:
        raise typer.Exit(1)


@store.command("evict")
def evict(
    older_than_days: Annotated[
        float, typer.Option("--older-than", help="Only files written this many days ago or earlier.", min=0.0)
    ],
    by: By = "",
    data: Data = None,
    json: Json = False,
) -> None:
    """Delete sessions from this disk whose objects are proven whole; takes stay."""
    from rehab_app.bootstrap import open_clinic
    from rehab_app.cli.acting import acting

    output = Output(json)
    with open_clinic(data) as clinic:
        gone = clinic.uploads.evict(acting(clinic, by), older_than_days)
    output.say(f"{len(gone)} sessions now lie in the object store only.")
    output.result({"evicted": list(gone)})


@store.command("fetch")
def fetch(
    named: Annotated[str, typer.Argument(metavar="SESSION", help="Catalogue id of a session or take.")],
    by: By = "",
    data: Data = None,
    json: Json = False,
) -> None:
    """Bring a file back from the object store, whole and proven."""
    from rehab_app.bootstrap import open_clinic
    from rehab_app.cli.acting import acting

    output = Output(json)
    with open_clinic(data) as clinic:
        path = clinic.uploads.fetch(acting(clinic, by), named)
    output.say(f"{path.name} is here, and its digest is as noted.")
    output.result({"file": path})
