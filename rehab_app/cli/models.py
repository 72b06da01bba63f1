"""The networks of markerless tracking: ``rehab-app camera models``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rehab_app.cli.options import Data, Json
from rehab_app.cli.output import Output
from rehab_app.cli.refusals import Commands

models = typer.Typer(
    cls=Commands, help="Networks that see a bare hand: get them, list them.", no_args_is_help=True
)


@models.command("install")
def install_models(
    source: Annotated[
        Path | None,
        typer.Option(
            "--from",
            help="Wheel of mediapipe 0.10.21 on this machine; else it is downloaded.",
            show_default=False,
        ),
    ] = None,
    data: Data = None,
    json: Json = False,
) -> None:
    """Obtain the two networks, check them and keep them in the user's cache."""
    del data  # every command takes it; this one touches no clinic folder
    from rehab_app.vision.markerless.install import PACKAGE, install

    output = Output(json)
    if source is None:
        output.say(f"The networks are taken from the wheel of {PACKAGE} (Apache-2.0); it is not installed.")
    installed = install(source)
    done = f"Installed: {', '.join(installed.fresh)}." if installed.fresh else "Nothing new was needed."
    output.say(f"{done} The networks lie in {installed.folder}.")
    output.result(
        {"folder": installed.folder, "fresh": list(installed.fresh), "models": _rows(installed.folder)}
    )


@models.command("list")
def list_models(data: Data = None, json: Json = False) -> None:
    """Say which networks there are and whether they are whole."""
    del data  # every command takes it; this one touches no clinic folder
    from rehab_app.vision.markerless.networks import INSTALL, cache_folder

    output = Output(json)
    folder = cache_folder()
    rows = _rows(folder)
    for row in rows:
        there = "installed" if row["installed"] else f"missing or damaged: run {INSTALL}"
        output.say(f"{row['name']}  {row['file']}  {there}")
    output.result({"folder": folder, "models": rows})


def _rows(folder: Path) -> list[dict[str, str | bool | int]]:
    from rehab_app.vision.markerless.networks import NETWORKS, is_installed

    return [
        {
            "name": network.name,
            "file": network.file,
            "bytes": network.bytes,
            "sha256": network.sha256,
            "installed": is_installed(network, folder),
        }
        for network in NETWORKS
    ]
