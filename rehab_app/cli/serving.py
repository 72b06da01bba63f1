"""The clinic in the browser, and the doctor that looks at this machine."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rehab_app.cli.options import Data, Json
from rehab_app.cli.output import Output

if TYPE_CHECKING:
    from rehab_app.config import Settings


def serve(
    host: Annotated[
        str | None, typer.Option("--host", help="Address to listen on.", show_default="127.0.0.1")
    ] = None,
    port: Annotated[
        int | None, typer.Option("--port", help="Port to listen on.", min=1, max=65535, show_default="8080")
    ] = None,
    certificate: Annotated[
        Path | None, typer.Option("--tls-cert", help="Certificate chain, PEM.", show_default=False)
    ] = None,
    key: Annotated[
        Path | None, typer.Option("--tls-key", help="Its private key, PEM.", show_default=False)
    ] = None,
    data: Data = None,
) -> None:
    """Open the clinic for browsers."""
    from rehab_app.config import load_settings, resolve_folder
    from rehab_app.web.server import ends_on_terminate
    from rehab_app.web.server_log import logging_to

    options = {"host": host, "port": port, "tls_cert": certificate, "tls_key": key}
    given = {f"server.{name}": value for name, value in options.items()}
    settings = load_settings(resolve_folder(data), given).settings
    with ends_on_terminate(), logging_to(settings.log, settings.station_name):
        _serve(Output(False), data, settings)


def _serve(output: Output, data: Path | None, settings: Settings) -> None:
    from rehab_app.bootstrap import check_port, open_clinic
    from rehab_app.cli.doctor import unsealed
    from rehab_app.config import ClinicFolder
    from rehab_app.web.tls import tls_files

    wanted = settings.server
    host, port = wanted.host, wanted.port
    tls = tls_files(_path(wanted.tls_cert), _path(wanted.tls_key))
    if tls is not None and tls.warning:
        output.say(tls.warning)
    check_port(host, port)
    with open_clinic(data, serving=True, settings=settings) as clinic:
        from rehab_app.web import serve as run

        for path in unsealed(ClinicFolder(clinic.folder)):
            output.say(f"{path.name} was never sealed; restore it with: rehab-app recover {path}")
        run(
            clinic,
            host=host,
            port=port,
            tls=tls,
            ready=lambda: output.say(
                f"The clinic is open at {'https' if tls else 'http'}://{shown(host)}:{port}"
                " - end it with Ctrl+C."
            ),
        )


def _path(named: str) -> Path | None:
    return Path(named).expanduser() if named else None


def doctor(
    port: Annotated[int, typer.Option("--port", help="Port that serve would use.")] = 8080,
    data: Data = None,
    json: Json = False,
) -> None:
    """Look at this machine: can it serve, simulate, and keep time?"""
    from rehab_app.cli.doctor import examine
    from rehab_app.config import resolve_folder

    output = Output(json)
    findings = examine(resolve_folder(data), port)
    for finding in findings:
        output.say(f"{'ok  ' if finding.ok else 'LOOK'}  {finding.name}: {finding.found}")
        if finding.remedy:
            output.say(f"      {finding.remedy}")
    output.result(
        {
            "ok": all(finding.ok for finding in findings),
            "checks": [
                {
                    "name": finding.name,
                    "ok": finding.ok,
                    "found": finding.found,
                    "remedy": finding.remedy,
                    "figures": finding.figures,
                }
                for finding in findings
            ],
        }
    )


def shown(host: str) -> str:
    """The address that a person types into a browser on this machine."""
    return "localhost" if host in ("127.0.0.1", "::1", "0.0.0.0") else host
