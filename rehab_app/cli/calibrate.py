"""Cameras: lens, places beside each other, world frame, marker colour."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, TypeAlias

import typer

from rehab_app.cli.options import Data, Json
from rehab_app.cli.output import Output
from rehab_app.cli.refusals import Commands

if TYPE_CHECKING:
    from rehab_app.calibration import CalibratedCamera, Corners, Rejected
    from rehab_app.calibration.board import Board
    from rehab_app.cameras import Camera as OpenedCamera

calibrate = typer.Typer(cls=Commands, help="Calibrate cameras; boards to do it with.", no_args_is_help=True)

BoardSpec: TypeAlias = Annotated[
    str,
    typer.Option("--board", help="Inner corners as 9x6, or squares as charuco:8x6."),
]
Square: TypeAlias = Annotated[float, typer.Option("--square", help="Side of a square, m (25 mm is 0.025).")]
Marker: TypeAlias = Annotated[
    float | None,
    typer.Option("--marker", help="Side of a marker, m; else 3/4 of the square.", show_default=False),
]
Dictionary: TypeAlias = Annotated[
    str, typer.Option("--dictionary", help="Markers of a charuco board, such as 4x4_50 or 5x5_250.")
]
Pictures: TypeAlias = Annotated[
    list[str] | None,
    typer.Argument(metavar="[IMAGES]...", help="Images, folders or patterns of them, or a video."),
]
Camera: TypeAlias = Annotated[
    str, typer.Option("--camera", help="Live camera, such as webcam:0, instead of images.")
]
Seconds: TypeAlias = Annotated[float, typer.Option("--seconds", help="How long to look at a camera, s.")]
Identity: TypeAlias = Annotated[
    str, typer.Option("--id", help="Under which the camera is kept; else --camera, or 'camera'.")
]
Known: TypeAlias = Annotated[
    str,
    typer.Option("--camera-intrinsics", help="Its calibration: a file, or a digest of the clinic."),
]
OutFile: TypeAlias = Annotated[
    Path | None, typer.Option("--out", help="JSON file to make as well.", show_default=False)
]


@calibrate.command("intrinsics")
def intrinsics(
    board: BoardSpec,
    square: Square,
    images: Pictures = None,
    marker: Marker = None,
    dictionary: Dictionary = "4x4_50",
    camera: Camera = "",
    seconds: Seconds = 30.0,
    identity: Identity = "",
    out: OutFile = None,
    data: Data = None,
    json: Json = False,
) -> None:
    """Find focal lengths, principal point and lens of a camera from images of a board."""
    from rehab_app.calibration import CalibratedCamera, calibrate_intrinsics, parse_board
    from rehab_app.calibration.files import check_target
    from rehab_app.cli.calibration_output import intrinsics_json, say_intrinsics

    output = Output(json)
    if out is not None:
        check_target(out)
    used = parse_board(board, square, marker, dictionary)
    fit = calibrate_intrinsics(_seen(used, images or [], camera, seconds), used)
    calibrated = CalibratedCamera(
        camera=identity or camera or "camera",
        intrinsics=fit.intrinsics,
        lens=fit.lens,
        method=f"{used.description}; {len(fit.views)} images",
        rms_px=fit.rms_px,
        verdict=fit.verdict.word,
    ).now()
    say_intrinsics(output, fit)
    kept = _keep(output, calibrated, out, data)
    output.result({**intrinsics_json(fit, calibrated), "kept": kept, "file": out})


@calibrate.command("stereo")
def stereo(
    board: BoardSpec,
    square: Square,
    images: Annotated[
        list[str],
        typer.Option("--images", help="Images of one camera: a folder, a pattern or a video. Two or more."),
    ],
    known: Annotated[
        list[str] | None,
        typer.Option("--camera-intrinsics", help="Calibration of each camera in order; else made as well."),
    ] = None,
    identities: Annotated[
        list[str] | None, typer.Option("--id", help="Id of each camera in order; else camera-1, camera-2.")
    ] = None,
    marker: Marker = None,
    dictionary: Dictionary = "4x4_50",
    out: Annotated[
        Path | None, typer.Option("--out", help="Folder for one JSON file a camera.", show_default=False)
    ] = None,
    data: Data = None,
    json: Json = False,
) -> None:
    """Find where two or more cameras (or colour and depth of one) stand beside the first."""
    from rehab_app.calibration import calibrate_rig, parse_board
    from rehab_app.calibration.pictures import at_once
    from rehab_app.calibration.rig_cameras import cameras_of, placed
    from rehab_app.cli.calibration_output import rig_json, say_rig
    from rehab_app.errors import Refused

    output = Output(json)
    if out is not None and not out.is_dir():
        raise Refused("--out", f"{out}, which is no folder", "a folder", "make it first")
    used = parse_board(board, square, marker, dictionary)
    seen = [_seen(used, [source], "", 0.0) for source in images]
    given = [_known(name, data) for name in known or []]
    cameras = cameras_of(seen, used, given, identities or [])
    fit = calibrate_rig(at_once(seen), used, [camera.known for camera in cameras])
    stand = placed(fit, cameras, used)
    say_rig(output, fit, stand)
    files = [None if out is None else out / f"{_file_name(camera.camera)}.json" for camera in stand]
    kept = [_keep(output, camera, file, data) for camera, file in zip(stand, files, strict=True)]
    output.result({**rig_json(fit, stand), "kept": all(kept), "files": files if out else []})


@calibrate.command("world")
def world(
    board: BoardSpec,
    square: Square,
    known: Known,
    images: Pictures = None,
    marker: Marker = None,
    dictionary: Dictionary = "4x4_50",
    camera: Camera = "",
    seconds: Seconds = 2.0,
    out: OutFile = None,
    data: Data = None,
    json: Json = False,
) -> None:
    """Find where a calibrated camera stands in the world: above a board that lies still."""
    from dataclasses import replace

    from rehab_app.calibration import parse_board, world_from_board
    from rehab_app.calibration.files import check_target
    from rehab_app.calibration.verdict import worse
    from rehab_app.cli.calibration_output import say_world, world_json

    output = Output(json)
    if out is not None:
        check_target(out)
    used = parse_board(board, square, marker, dictionary)
    calibrated = _known(known, data)
    fit = world_from_board(_seen(used, images or [], camera, seconds), used, calibrated)
    worth = worse(calibrated.verdict, fit.verdict.word)
    stands = replace(calibrated, world=fit.placement, verdict=worth).now()
    say_world(output, fit)
    kept = _keep(output, stands, out, data)
    output.result({**world_json(fit, stands), "kept": kept, "file": out})


@calibrate.command("colour")
def colour(
    known: Known,
    at: Annotated[
        str,
        typer.Option("--at", help="Pixel in the middle of a marker, as u,v; else markers are looked for."),
    ] = "",
    image: Annotated[
        Path | None, typer.Option("--image", help="Picture in which markers are seen.", show_default=False)
    ] = None,
    camera: Camera = "",
    out: OutFile = None,
    data: Data = None,
    json: Json = False,
) -> None:
    """Learn the colour of the markers in a picture, and keep it with the camera."""
    from rehab_app.calibration.files import check_target
    from rehab_app.calibration.marker_colour import frame_of, picture_of, pixel_named, with_colour
    from rehab_app.vision import colour_from_json

    output = Output(json)
    if out is not None:
        check_target(out)
    pixel_px = pixel_named(at) if at else None
    calibrated = _known(known, data)
    _one_source(image is not None, bool(camera))
    if image is not None:
        learnt = with_colour(calibrated, picture_of(image), None, pixel_px)
    else:
        with _opened(camera) as opened:
            frame = frame_of(opened)
        learnt = with_colour(calibrated, frame.colour_bgr, frame.depth_m, pixel_px)
    ink_bgr = colour_from_json(learnt.colour).ink_bgr
    blue, green, red = (round(value) for value in ink_bgr)
    output.say(
        f"The markers of camera {learnt.camera} are of the colour red {red} green {green} blue {blue}."
    )
    kept = _keep(output, learnt, out, data)
    output.result({**learnt.table(), "digest": learnt.digest, "kept": kept, "file": out})


def _seen(board: Board, images: list[str], camera: str, seconds: float) -> list[Corners | Rejected]:
    """The board in every image, or in what a camera shows for a while."""
    from rehab_app.calibration.pictures import look_for, pictures, pictures_of
    from rehab_app.cli.progress import frames_bar

    _one_source(bool(images), bool(camera))
    with frames_bar("Looking for the board") as told:
        if not camera:
            return look_for(board, pictures(images), told)
        with _opened(camera) as opened:
            return look_for(board, pictures_of(opened.frames(), seconds), told)


def _one_source(images: bool, camera: bool) -> None:
    from rehab_app.errors import Refused

    if images == camera:
        raise Refused(
            "source of the images",
            "given twice" if camera else "missing",
            "images or a camera",
            "name image files, or a camera with --camera",
        )


def _opened(spec: str) -> OpenedCamera:
    from rehab_app.cameras import open_camera

    return open_camera(spec)


def _known(named: str, data: Path | None) -> CalibratedCamera:
    """A calibration by file, else by the beginning of its digest."""
    from rehab_app.calibration import load_camera
    from rehab_app.services.storage import is_path

    if is_path(named):
        return load_camera(Path(named))
    from rehab_app.bootstrap import open_clinic

    with open_clinic(data) as clinic:
        return clinic.calibrations.get(named)


def _keep(output: Output, camera: CalibratedCamera, out: Path | None, data: Path | None) -> bool:
    """Keep a calibration in the clinic unless it is to be redone; write the file in any case."""
    from rehab_app.access import CONSOLE
    from rehab_app.bootstrap import open_clinic
    from rehab_app.calibration import save_camera

    if out is not None:
        save_camera(camera, out)
        output.say(f"Written to {out}.")
    if camera.verdict == "redo":
        output.say("Not kept in the clinic: a calibration that is to be redone would only mislead.")
        return False
    with open_clinic(data) as clinic:
        row = clinic.calibrations.add(CONSOLE, camera)
    output.say(f"Kept as {row.digest[:12]} of camera {row.camera}.")
    return True


def _file_name(camera: str) -> str:
    return "".join(letter if letter.isalnum() or letter in "-_." else "-" for letter in camera)
