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
    file: Annotated[
        Path,
        typer.Argument(
            metavar="FILE", help="Qualisys .tsv, .c3d, Leap .json.lz, landmark .npz or glove .csv."
        ),
    ],
    side: Side = "",
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
    exercise: Annotated[
        str, typer.Option("--exercise", help="Movement; one of the virtual camera's where that records.")
    ] = "open_close",
    side: Side = "right",
    seconds: Annotated[float, typer.Option("--seconds", help="Length, s.")] = 8.0,
    camera: Annotated[
        list[str] | None,
        typer.Option(
            "--camera",
            help="Camera as `camera list` names it, such as webcam:0; more to look on from elsewhere.",
            show_default="virtual",
        ),
    ] = None,
    protocol: Annotated[
        str, typer.Option("--protocol", help="Marker protocol, by name or TOML file.")
    ] = "thesis25",
    tracker: Annotated[str, typer.Option("--tracker", help="kinematic or rbmcda.")] = "kinematic",
    person: Annotated[
        str,
        typer.Option("--subject", "--patient", help="Id (never a name) of whose hand it is."),
    ] = "",
    consent_images: Annotated[
        bool, typer.Option("--consent-images", help="The person consented: store the images too.")
    ] = False,
    seed: Seed = 1,
    out: Out = None,
    data: Data = None,
    json: Json = False,
) -> None:
    """Record a take from a camera."""
    from rehab_app.access import CONSOLE
    from rehab_app.bootstrap import open_clinic
    from rehab_app.cli.progress import watching
    from rehab_app.services.patients import side_named
    from rehab_app.services.recording_request import VIRTUAL, RecordingRequest

    output = Output(json)
    first, *beside = camera or [VIRTUAL]
    request = RecordingRequest(
        exercise=exercise,
        side=side_named(side),
        seconds=seconds,
        camera=first,
        beside=tuple(beside),
        protocol=protocol,
        tracker=tracker,
        person=person,
        consent_images=consent_images,
        seed=seed,
    )
    with open_clinic(data) as clinic, watching(output, seconds) as listeners:
        summary = clinic.takes.record(request, CONSOLE, out, listeners)
    for complaint in summary.recording.complaints if summary.recording else ():
        output.say(complaint)
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
    recording = summary.recording
    more: dict[str, Any] = {}
    if recording is not None:
        more = {
            "dropped": recording.dropped,
            "measured_share": recording.measured_share,
            "estimated_share": recording.estimated_share,
            "lost_share": recording.lost_share,
            "residual_m": recording.residual_m,
            "complaints": list(recording.complaints),
        }
    return {
        "take": summary.path,
        "id": summary.take,
        "duration_s": summary.duration_s,
        "landmarks": summary.landmarks,
        "frames": summary.frames,
        "gaps": summary.gaps,
        **more,
    }


def _tell(output: Output, summary: ImportedSummary) -> None:
    output.say(
        f"Take {summary.take}: {summary.duration_s:.1f} s, {summary.frames} frames of {summary.landmarks} "
        f"landmarks, {summary.gaps} gaps. It lies in {summary.path}."
    )
    output.say(f"Approve it with: rehab-app approve {summary.take} --by NAME")
    output.result(summary_json(summary))
