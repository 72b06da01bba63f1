"""Moving a clinic's catalogue to a data base on a server."""

from __future__ import annotations

from dataclasses import asdict
from typing import Annotated

import typer

from rehab_app.cli.options import By, Data, Json
from rehab_app.cli.output import Output


def migrate(
    to: Annotated[
        str,
        typer.Option("--to", metavar="URL", help="postgresql://USER:PASSWORD@HOST/NAME, an empty data base."),
    ],
    by: By = "",
    data: Data = None,
    json: Json = False,
) -> None:
    """Move the catalogue from the clinic folder to a data base on a server, and prove that nothing was lost.

    The server of the clinic must not run. The old file stays; recordings stay in the folder. Afterwards the
    new address is written into the configuration, and the clinic works there.
    """
    from rehab_app.bootstrap import open_clinic
    from rehab_app.cli.acting import acting
    from rehab_app.services.moving import move_catalogue

    output = Output(json)
    with open_clinic(data, serving=True) as clinic:
        moved = move_catalogue(clinic.catalogue, clinic.audit, acting(clinic, by), to)
    for table in moved:
        output.say(f"{table.name:24} {table.rows:8} rows  {table.sha256[:16]}")
    rows = sum(table.rows for table in moved)
    output.say(f"{rows} rows of {len(moved)} tables are the same there. Now write into rehab-app.toml:")
    output.say('  catalogue_url = "postgresql://..."   (or set REHAB_CATALOGUE_URL)')
    output.result({"rows": rows, "tables": [asdict(table) for table in moved]})
