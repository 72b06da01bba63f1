"""``rehab-app camera``: which cameras there are, a look through one, and the networks for bare hands."""

from __future__ import annotations

import math
import os
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from rehab_app.cli.models import models
from rehab_app.cli.options import Data, Json
from rehab_app.cli.output import Output

if TYPE_CHECKING:
    from rehab_app.cameras.preview import Look

camera = typer.Typer(help="Cameras: list them, look through one.", invoke_without_command=True)
camera.add_typer(models, name="models")


@camera.callback()
def root(context: typer.Context, data: Data = None, json: Json = False) -> None:
    """Cameras: list them, look through one."""
    if context.invoked_subcommand is None:
        list_(data, json)


@camera.command("list")
def list_(data: Data = None, json: Json = False) -> None:
    """List the cameras of this machine."""
    del data  # every command takes it; this one touches no clinic folder
    from rehab_app.cameras import list_cameras

    output = Output(json)
    found = list_cameras()
    for one in found:
        depth = "colour and depth" if one.has_depth else "colour only"
        output.say(f"{one.id:24} {one.state:12} {one.label} ({depth}). {one.remedy}".rstrip())
    output.say("A video or a recorded session is a camera too: video:FILE, session:FILE.")
    output.result({"cameras": [asdict(one) for one in found]})


@camera.command("preview")
def preview(
    name: Annotated[str, typer.Argument(metavar="CAMERA", help="As camera list names it.")] = "virtual",
    seconds: Annotated[float, typer.Option("--seconds", help="How long to look, s.")] = 2.0,
    out: Annotated[Path, typer.Option("--out", help="Picture to write (PNG or JPEG).")] = Path("preview.png"),
    data: Data = None,
    json: Json = False,
) -> None:
    """Look through a camera; write one picture with the markers that were found in it."""
    del data  # every command takes it; this one touches no clinic folder
    import cv2

    from rehab_app.cameras import open_camera
    from rehab_app.cameras.preview import look_through
    from rehab_app.vision import make_detector
    from rehab_app.vision.exposure import picture_fault

    output = Output(json)
    encoding = _encoding(out)
    look = look_through(open_camera(name), seconds)
    frame = look.last
    fault = picture_fault(frame.colour_bgr, frame.depth_m)
    found = make_detector().detect(frame.t_capture_ns, frame.colour_bgr, frame.depth_m, frame.intrinsics)
    picture = frame.colour_bgr.copy()
    for u, v in found.pixel_px:
        cv2.circle(picture, (round(8 * u), round(8 * v)), 8 * 9, (90, 220, 60), 2, cv2.LINE_AA, 3)
    _write(out, bytes(cv2.imencode(encoding, picture)[1]))
    _tell(output, look, fault, len(found), out)


def _encoding(out: Path) -> str:
    """The kind of picture that a file name asks for.

    Raises:
        Refused: None that can be written.
    """
    from rehab_app.errors import Refused

    kind = out.suffix.lower()
    if kind not in (".png", ".jpg", ".jpeg"):
        raise Refused("--out", repr(out.name), "a PNG or JPEG file", "name it preview.png, for example")
    return kind


def _write(out: Path, content: bytes) -> None:
    """Put a whole file in place, or none."""
    beside = out.with_name(f".{out.name}.part")
    try:
        beside.write_bytes(content)
        os.replace(beside, out)
    finally:
        beside.unlink(missing_ok=True)


def _tell(output: Output, look: Look, fault: str | None, markers: int, out: Path) -> None:
    rate = "one frame" if math.isnan(look.rate_hz) else f"{look.rate_hz:.1f} frames a second"
    output.say(
        f"{look.camera}: {look.width_px} x {look.height_px} px, {rate}, {look.dropped} lost, "
        f"brightness {100.0 * look.brightness:.0f} %, {_depth_words(look)}."
    )
    for sentence in (*look.outages, *([fault] if fault else [])):
        output.say(sentence)
    output.say(f"{markers} blue markers in the last picture: {out}")
    output.result(_as_json(look, fault, markers, out))


def _depth_words(look: Look) -> str:
    if look.depth_share is None:
        return "no depth: what it sees is followed in the picture only, without distances"
    middle = "" if look.depth_m is None else f", in the middle {look.depth_m:.2f} m away"
    return f"depth in {100.0 * look.depth_share:.0f} % of the picture{middle}"


def _as_json(look: Look, fault: str | None, markers: int, out: Path) -> dict[str, Any]:
    return {
        "camera": look.camera,
        "frames": look.frames,
        "rate_hz": None if math.isnan(look.rate_hz) else look.rate_hz,
        "width_px": look.width_px,
        "height_px": look.height_px,
        "has_depth": look.depth_share is not None,
        "depth_share": look.depth_share,
        "depth_m": look.depth_m,
        "brightness": look.brightness,
        "dropped": look.dropped,
        "outages": list(look.outages),
        "fault": fault,
        "markers": markers,
        "picture": out,
    }
