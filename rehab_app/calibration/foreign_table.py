"""Camera files of other programs, under the many names that they give the same six numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from rehab_app.calibration.camera import CalibratedCamera, Placement
from rehab_app.errors import Refused
from rehab_app.geometry.lens import Lens
from rehab_app.geometry.pinhole import Intrinsics
from sessions.records.fields import Float64

_NAMES: dict[str, tuple[str, ...]] = {
    "fx": ("fx_px", "fx", "f_x", "focal_x", "focal_px", "f"),
    "fy": ("fy_px", "fy", "f_y", "focal_y", "focal_px", "f"),
    "cx": ("cx_px", "cx", "c_x", "ppx", "px", "u0"),
    "cy": ("cy_px", "cy", "c_y", "ppy", "py", "v0"),
    "width": ("width_px", "width", "image_width", "w"),
    "height": ("height_px", "height", "image_height", "h"),
}
_SIZES = ("image_size", "resolution", "size", "size_px", "img_size")
_MATRICES = ("camera_matrix", "cameraMatrix", "Camera_Matrix", "K", "k", "mtx", "intrinsic_matrix", "matrix")
_LENSES = (
    "distortion",
    "distortion_coefficients",
    "Distortion_Coefficients",
    "dist_coeffs",
    "distCoeffs",
    "dist_coeff",
    "dist",
    "coeffs",
    "D",
    "d",
)
_MODELS = ("distortion_model", "model")
_OTHER_MODELS = ("fisheye", "equidistant", "kannala", "omni", "ftheta", "scaramuzza")
_NESTED = ("intrinsics", "color", "colour", "rgb", "color_intrinsics", "camera")


def foreign_camera(table: Mapping[str, Any], path: Path) -> CalibratedCamera:
    """A camera from a table of another program.

    Args:
        table: What the file holds.
        path: The file.

    Raises:
        Refused: Something is missing, or the numbers are those of no camera.
    """
    flat = _flat(table)
    model = str(next((flat[name] for name in _MODELS if isinstance(flat.get(name), str)), ""))
    if any(other in model.lower() for other in _OTHER_MODELS):
        raise Refused(
            f"distortion model of {path.name}",
            repr(model),
            "plumb_bob or rational_polynomial",
            "calibrate the camera with rehab-app calibrate intrinsics",
        )
    numbers = _with_size(_with_matrix(flat))
    found = {name: _number(numbers, name, path) for name in _NAMES}
    width, height = found["width"], found["height"]
    if not (float(width).is_integer() and float(height).is_integer()):
        raise Refused(f"image size in {path.name}", f"{width:g} x {height:g}", "whole pixels", "correct it")
    residual: Any = flat.get("rms_px", flat.get("avg_reprojection_error", flat.get("rms")))
    given: Any = table.get("camera", flat.get("camera_name", path.stem))
    return CalibratedCamera(
        camera=given if isinstance(given, str) else path.stem,
        intrinsics=Intrinsics(found["fx"], found["fy"], found["cx"], found["cy"], int(width), int(height)),
        lens=Lens(_lens(flat, path)),
        method=f"read from {path.suffix.lstrip('.').upper() or 'a'} file of another program",
        rms_px=float(residual) if isinstance(residual, int | float) else float("nan"),
        placement=_placement(flat, "tracking", path),
        world=_placement(flat, "world", path),
    )


def opencv_table(text: str, path: Path) -> dict[str, Any]:
    """The content of a YAML or XML file as OpenCV writes and reads it; ROS's lacks only the first line.

    Raises:
        Refused: The text is neither.
    """
    plain = text if text.lstrip().startswith(("%YAML", "<")) else f"%YAML:1.0\n---\n{text}"
    try:
        storage = cv2.FileStorage(plain, cv2.FILE_STORAGE_READ | cv2.FILE_STORAGE_MEMORY)
        content: Any = _value(storage.root())
        storage.release()
    except (cv2.error, SystemError) as error:
        raise Refused(
            f"calibration {path.name}",
            "no YAML or XML that can be read",
            "a file of OpenCV or ROS, or JSON",
            "make one with rehab-app calibrate intrinsics",
        ) from error
    return content if isinstance(content, dict) else {}


def _value(node: Any) -> Any:
    if node.isMap():
        keys: Sequence[str] = node.keys()
        if {"rows", "cols", "data"} <= set(keys):
            return _value(node.getNode("data"))
        return {key: _value(node.getNode(key)) for key in keys}
    if node.isSeq():
        return [_value(node.at(row)) for row in range(node.size())]
    if node.isString():
        return node.string()
    return node.real() if node.isInt() or node.isReal() else None


def _placement(flat: Mapping[str, Any], frame: str, path: Path) -> Placement | None:
    found: Any = flat.get(f"T_{frame}_camera")
    if found is None:
        return None
    values = _array(found)
    if values is None or values.size not in (12, 16):
        raise Refused(f"T_{frame}_camera in {path.name}", "no matrix", "4 x 4 numbers", "correct the file")
    matrix = values.reshape(-1, 4)
    return Placement(frame, matrix[:3, :3], matrix[:3, 3], float("nan"))


def _flat(table: Mapping[str, Any]) -> dict[str, Any]:
    """The table with what lies under "intrinsics" and the like lifted up, where the top does not say it."""
    flat: dict[str, Any] = {str(key): value for key, value in table.items()}
    for name in _NESTED:
        inner: Any = table.get(name)
        if isinstance(inner, Mapping):
            flat = {**_flat({str(key): inner[key] for key in inner}), **flat}
    return flat


def _with_matrix(flat: dict[str, Any]) -> dict[str, Any]:
    found: Any = next((flat[name] for name in _MATRICES if flat.get(name) is not None), None)
    values = _array(found)
    if values is None or values.size != 9:
        return flat
    matrix = values.reshape(3, 3)
    named = {"fx": matrix[0, 0], "fy": matrix[1, 1], "cx": matrix[0, 2], "cy": matrix[1, 2]}
    return {**named, **flat}


def _with_size(flat: dict[str, Any]) -> dict[str, Any]:
    found: Any = next((flat[name] for name in _SIZES if flat.get(name) is not None), None)
    values = _array(found)
    if values is None or values.size != 2:
        return flat
    return {"width": values[0], "height": values[1], **flat}


def _array(found: Any) -> Float64 | None:
    inner: Any = found.get("data") if isinstance(found, Mapping) else found
    try:
        return None if inner is None else np.asarray(inner, dtype=np.float64).reshape(-1)
    except (TypeError, ValueError):
        return None


def _number(flat: Mapping[str, Any], name: str, path: Path) -> float:
    found: Any = next((flat[other] for other in _NAMES[name] if flat.get(other) is not None), None)
    try:
        number = float(found)
    except (TypeError, ValueError):
        number = float("nan")
    if not np.isfinite(number):
        value = "missing" if found is None else repr(found)[:40]
        raise Refused(f"{name} in {path.name}", value, "a finite number of pixels", "add it to the file")
    return number


def _lens(flat: Mapping[str, Any], path: Path) -> tuple[float, ...]:
    found: Any = next((flat[name] for name in _LENSES if flat.get(name) is not None), None)
    if found is None:
        named = [flat.get(name) for name in ("k1", "k2", "p1", "p2", "k3")]
        if named[0] is None:
            return ()
        found = [0.0 if value is None else value for value in named]
    values = _array(found)
    if values is None:
        raise Refused(f"distortion in {path.name}", repr(found)[:40], "a list of numbers", "correct the file")
    numbers = tuple(float(value) for value in values)
    while len(numbers) > 8 and numbers[-1] == 0.0:
        numbers = numbers[:-1]
    if len(numbers) in (1, 2, 3, 6, 7):
        numbers = (*numbers, *[0.0] * ((4 if len(numbers) < 4 else 8) - len(numbers)))
    return numbers if any(numbers) else ()
