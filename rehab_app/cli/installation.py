"""This installation: the settings that hold here, and the unit that lets systemd run it."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from rehab_app.cli.options import Data, Json
from rehab_app.cli.output import Output


def config(data: Data = None, json: Json = False) -> None:
    """Show every setting with its value and where it comes from; secrets are not shown."""
    from rehab_app.config import KEYS, load_settings, resolve_folder

    output = Output(json)
    loaded = load_settings(resolve_folder(data))
    rows: dict[str, Any] = {}
    for key in KEYS:
        value, origin = key.shown(loaded.settings), loaded.origins[key.dotted]
        rows[key.dotted] = {"value": value, "origin": origin, "variable": key.variable}
        output.say(f"{key.dotted} = {value!r}  ({origin})")
    output.say(f"File: {loaded.file}" if loaded.file else "No file was read.")
    output.result({"file": loaded.file, "settings": rows})


def unit(
    user: Annotated[
        str, typer.Option("--user", help="Account that runs it.", show_default="one that systemd makes")
    ] = "",
    data: Data = None,
    json: Json = False,
) -> None:
    """Print the systemd unit of this installation, to be written to /etc/systemd/system/rehab-app.service."""
    from rehab_app.cli.systemd_unit import unit_text

    text = unit_text(user, None if data is None else data.expanduser().absolute())
    if json:
        Output(json).result({"unit": text})
    else:
        typer.echo(text, nl=False)


def use_file(context: typer.Context, file: Path | None) -> None:
    """Read the settings from a file for the length of this command, and in every process that it starts."""
    import os

    from rehab_app.config import FILE_VARIABLE

    if file is None:
        return
    before = os.environ.get(FILE_VARIABLE)
    os.environ[FILE_VARIABLE] = str(file.expanduser().absolute())

    def back() -> None:
        if before is None:
            os.environ.pop(FILE_VARIABLE, None)
        else:
            os.environ[FILE_VARIABLE] = before

    context.call_on_close(back)
