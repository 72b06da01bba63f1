"""Trajectories out of recordings: ``rehab-app track``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from rehab_app.cli.options import Data, Json, Seed, Side
from rehab_app.cli.output import Output

if TYPE_CHECKING:
    from rehab_app.recording.track_order import TrackResult


def track(
    inputs: Annotated[
        list[Path],
        typer.Argument(
            metavar="INPUT...",
            help="Detections (.npz), a video, or an RGB-D session; several for several cameras.",
        ),
    ],
    out: Annotated[Path, typer.Option("--out", help="File to make: take.mcap or tracks.npz.")],
    protocol: Annotated[
        str | None, typer.Option("--protocol", help="Marker protocol, by name or TOML file.")
    ] = None,
    tracker: Annotated[str, typer.Option("--tracker", help="kinematic or rbmcda.")] = "kinematic",
    side: Side = "right",
    camera_intrinsics: Annotated[
        list[Path] | None,
        typer.Option(
            "--camera-intrinsics",
            help="Calibration file of the camera; one for each of several inputs.",
            show_default=False,
        ),
    ] = None,
    detector: Annotated[str, typer.Option("--detector", help="contrast or histogram.")] = "contrast",
    overlay: Annotated[
        Path | None,
        typer.Option("--overlay", help="Video to draw the tracks in (.mp4, .avi).", show_default=False),
    ] = None,
    subject: Annotated[
        Path | None,
        typer.Option("--subject", help="Take that states this person's hand.", show_default=False),
    ] = None,
    label: Annotated[
        list[str] | None,
        typer.Option(
            "--label",
            metavar="NAME=U,V",
            help="A marker and where it is in the first picture, px; repeat it for each, 4 or more.",
            show_default=False,
        ),
    ] = None,
    exercise: Annotated[str, typer.Option("--exercise", help="Name of the movement.")] = "",
    seed: Seed = 0,
    data: Data = None,
    json: Json = False,
) -> None:
    """Name the markers of a recording and fit the hand: a take, or plain arrays."""
    del data  # every command takes it; this one touches no clinic folder
    from rehab_app import __version__
    from rehab_app.cli.progress import frames_bar
    from rehab_app.recording.labels import labels_of
    from rehab_app.recording.track import track as track_recording
    from rehab_app.recording.track_order import TrackOrder
    from rehab_app.recording.track_subject import subject_of
    from rehab_app.services.patients import side_named

    output = Output(json)
    order = TrackOrder(
        inputs=tuple(_file(one) for one in inputs),
        out=out,
        side=side_named(side),
        protocol=protocol,
        tracker=tracker,
        software_version=__version__,
        detector=detector,
        cameras=tuple(camera_intrinsics or ()),
        overlay=overlay,
        subject=None if subject is None else subject_of(subject),
        exercise=exercise,
        seed=seed,
        labels=labels_of(label or ()),
    )
    with frames_bar("Tracking") as progress:
        result = track_recording(order, progress)
    _tell(output, result)


def _file(spec: Path) -> Path:
    """The file of an input, also where it is spelled as ``camera list`` spells files."""
    kind, _, rest = str(spec).partition(":")
    return Path(rest) if kind in ("video", "session") and rest and not spec.exists() else spec


def result_json(result: TrackResult) -> dict[str, Any]:
    """The result, as JSON: the file under ``take`` or ``tracks``."""
    kind = "take" if result.sha256 else "tracks"
    return {
        kind: result.out,
        "sha256": result.sha256 or None,
        "protocol": result.protocol,
        "tracker": result.tracker,
        "markers": result.markers,
        "frames": result.frames,
        "dropped": result.dropped,
        "duration_s": result.duration_s,
        "measured_share": result.measured_share,
        "estimated_share": result.estimated_share,
        "lost_share": result.lost_share,
        "residual_m": result.residual_m,
        "ms_per_frame": result.ms_per_frame,
        "complaints": list(result.complaints),
        "overlay": result.overlay,
    }


def _tell(output: Output, result: TrackResult) -> None:
    for complaint in result.complaints:
        output.say(complaint)
    output.say(
        f"{result.frames} frames, {result.markers} markers: {100 * result.measured_share:.1f} % measured, "
        f"{100 * result.estimated_share:.1f} % estimated, {100 * result.lost_share:.1f} % lost; "
        f"{1e3 * result.residual_m:.1f} mm residual, {result.ms_per_frame:.1f} ms a frame. "
        f"It lies in {result.out}."
    )
    output.result(result_json(result))
