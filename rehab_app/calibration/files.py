"""Calibrations as files: the application's own JSON, and what other programs write."""

from __future__ import annotations

import json
import os
import uuid
from pathlib import Path
from typing import Any

import numpy as np

from rehab_app.calibration.camera import FORMAT, FORMAT_VERSION, CalibratedCamera, Placement, digest_of
from rehab_app.calibration.foreign_table import foreign_camera, opencv_table
from rehab_app.errors import Refused
from rehab_app.geometry.lens import Lens
from rehab_app.geometry.pinhole import Intrinsics

_LARGEST_BYTES = 4_000_000


def load_camera(path: Path) -> CalibratedCamera:
    """A calibrated camera from a file.

    Read are the application's own JSON; JSON with at least fx fy cx cy width height (also with units in the
    names, nested under "intrinsics", or as ``camera_matrix`` with ``distortion_coefficients``; a camera's
    place as ``T_tracking_camera`` or ``T_world_camera``, 4 x 4); and the YAML or XML of OpenCV and ROS.

    Args:
        path: The file.

    Raises:
        Refused: The file cannot be read, says too little, or its numbers are those of no camera.
    """
    text = _text(path)
    if path.suffix.lower() in (".yml", ".yaml", ".xml"):
        return foreign_camera(opencv_table(text, path), path)
    return camera_from_json(text, path)


def camera_from_json(text: str, path: Path = Path("calibration")) -> CalibratedCamera:
    """A calibrated camera from JSON, the application's own or a plain one.

    Args:
        text: The JSON.
        path: The file it came from, for refusals and as the camera's id where the text gives none.

    Raises:
        Refused: As ``load_camera``.
    """
    try:
        table: Any = json.loads(text)
    except (json.JSONDecodeError, RecursionError) as error:
        raise _unreadable(path, f"no JSON ({error})") from error
    if not isinstance(table, dict):
        raise _unreadable(path, "no JSON object")
    if table.get("format") != FORMAT:
        return foreign_camera(table, path)
    return _own(table, path)


def camera_to_json(camera: CalibratedCamera) -> str:
    """The file's content, digest included."""
    table = camera.table()
    return json.dumps({**table, "digest": digest_of(table)}, indent=2, ensure_ascii=True) + "\n"


def save_camera(camera: CalibratedCamera, path: Path) -> Path:
    """Write a calibration file; it is whole or absent.

    Args:
        camera: The calibrated camera.
        path: A file ending in .json whose folder exists; one that is there already is replaced.

    Raises:
        Refused: The name does not end in .json, or the folder does not exist.
    """
    check_target(path)
    working = path.with_name(f".{path.name}.{uuid.uuid4().hex[:8]}")
    try:
        working.write_text(camera_to_json(camera), encoding="utf-8")
        os.replace(working, path)
    finally:
        working.unlink(missing_ok=True)
    return path


def check_target(path: Path, suffixes: tuple[str, ...] = (".json",)) -> None:
    """Refuse a file name that cannot be written, before any work is done.

    Raises:
        Refused: It has another ending, is a folder, or its folder does not exist.
    """
    if path.suffix.lower() not in suffixes:
        raise Refused("--out", str(path), "a file ending in " + " or ".join(suffixes), "give it that ending")
    if path.is_dir():
        raise Refused("--out", f"{path}, which is a folder", "a file", "choose another name")
    if not path.parent.is_dir():
        raise Refused("folder of --out", f"{path.parent}, which does not exist", "a folder", "make it first")


def _own(table: dict[str, Any], path: Path) -> CalibratedCamera:
    version = table.get("format_version")
    if not isinstance(version, int) or not 1 <= version <= FORMAT_VERSION:
        raise Refused(
            f"format version of {path.name}",
            repr(version),
            f"1 to {FORMAT_VERSION}",
            "open it with a newer rehab-app",
        )
    try:
        if table.get("digest", "") not in ("", digest_of(table)):
            raise Refused(
                f"calibration {path.name}",
                "changed since it was made",
                "what its digest says",
                "take the original, or delete the line with the digest to make it a calibration of its own",
            )
        return _camera(table)
    except (KeyError, TypeError, ValueError, OverflowError) as error:
        raise _unreadable(path, f"incomplete ({error})") from error


def _camera(table: dict[str, Any]) -> CalibratedCamera:
    fx, fy, cx, cy = (float(table[name]) for name in ("fx_px", "fy_px", "cx_px", "cy_px"))
    rms: Any = table.get("rms_px")
    colour: Any = table.get("colour")
    return CalibratedCamera(
        camera=str(table["camera"]),
        intrinsics=Intrinsics(fx, fy, cx, cy, int(table["width_px"]), int(table["height_px"])),
        lens=Lens(tuple(float(value) for value in table["distortion"])),
        method=str(table.get("method", "")),
        rms_px=float("nan") if rms is None else float(rms),
        verdict=str(table.get("verdict", "unknown")),
        created_utc=str(table.get("created_utc", "")),
        placement=_placement(table.get("placement")),
        world=_placement(table.get("world")),
        colour="" if colour is None else json.dumps(colour, sort_keys=True),
    )


def _placement(table: Any) -> Placement | None:
    if table is None:
        return None
    rms: Any = table.get("rms_px")
    return Placement(
        str(table["reference"]),
        np.asarray(table["rotation"], dtype=np.float64),
        np.asarray(table["p_m"], dtype=np.float64),
        float("nan") if rms is None else float(rms),
    )


def _text(path: Path) -> str:
    if not path.is_file():
        raise Refused(
            f"calibration {path}", "no file", "a JSON or YAML file with camera intrinsics", "check the path"
        )
    if path.stat().st_size > _LARGEST_BYTES:
        raise _unreadable(path, "too large for one")
    try:
        return path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise _unreadable(path, "no text") from error


def _unreadable(path: Path, why: str) -> Refused:
    return Refused(
        f"calibration {path.name}",
        why,
        "JSON with fx fy cx cy width height, or OpenCV's or ROS's YAML",
        "make one with rehab-app calibrate intrinsics",
    )
