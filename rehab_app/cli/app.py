"""The commands of ``rehab-app``; each imports what it needs when it runs, so that ``--help`` is quick."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rehab_app import __version__
from rehab_app.cli import clinical, demo, files, people, privacy, recording, serving, therapy, track
from rehab_app.cli.assess import assess
from rehab_app.cli.calibration_files import calibrate
from rehab_app.cli.camera import camera
from rehab_app.cli.exercises import exercise, withdraw
from rehab_app.cli.grasp import grasp
from rehab_app.cli.installation import config, unit, use_file
from rehab_app.cli.limits import limits
from rehab_app.cli.migrate import migrate
from rehab_app.cli.patient_more import outcome
from rehab_app.cli.progress_report import progress
from rehab_app.cli.propose import propose
from rehab_app.cli.recompute import recompute
from rehab_app.cli.refusals import Commands
from rehab_app.cli.repeatability import repeatability
from rehab_app.cli.report import report
from rehab_app.cli.retouch import retouch
from rehab_app.cli.stations import stations
from rehab_app.cli.store import store

app = typer.Typer(
    name="rehab-app",
    cls=Commands,
    help="Record a therapist's hand, replay it on a hand robot, report the patient's progress.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)


def _show_version(wanted: bool) -> None:
    if wanted:
        typer.echo(__version__)
        raise typer.Exit


@app.callback()
def root(
    context: typer.Context,
    file: Annotated[
        Path | None,
        typer.Option(
            "--config",
            help="Settings (else REHAB_CONFIG, else rehab-app.toml in the clinic folder).",
            show_default=False,
        ),
    ] = None,
    version: Annotated[
        bool, typer.Option("--version", callback=_show_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    """Record a therapist's hand, replay it on a hand robot, report the patient's progress."""
    use_file(context, file)


app.command("demo")(demo.demo)
app.command("serve")(serving.serve)
app.command("doctor")(serving.doctor)
app.command("config")(config)
app.command("unit")(unit)
app.command("import")(recording.import_)
app.command("record")(recording.record)
app.command("track")(track.track)
app.command("approve")(recording.approve)
app.command("retouch")(retouch)
app.command("withdraw")(withdraw)
app.command("rehearse")(therapy.rehearse)
app.command("play")(therapy.play)
app.command("assess")(assess)
app.command("grasp")(grasp)
app.command("report")(report)
app.command("progress")(progress)
app.command("propose")(propose)
app.command("repeatability")(repeatability)
app.command("recompute")(recompute)
app.command("info")(files.info)
app.command("verify")(files.verify)
app.command("recover")(files.recover)
app.command("migrate")(migrate)
app.command("stations")(stations)
app.command("backup")(privacy.backup)
app.command("restore")(privacy.restore)
app.command("export")(privacy.export)
app.add_typer(calibrate, name="calibrate")
app.add_typer(camera, name="camera")
app.add_typer(clinical.patient, name="patient")
clinical.patient.add_typer(outcome, name="outcome")
app.add_typer(exercise, name="exercise")
app.add_typer(limits, name="limits")
app.add_typer(people.user, name="user")
app.add_typer(privacy.retention, name="retention")
app.add_typer(store, name="store")
