"""The C3D format (c3d.org user guide), as much of it as 3-D points need; every size is checked before use.

Read here rather than by a library in C++: a damaged file must become a refusal, not the end of the process.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from rehab_app.recording.importers.recorded_file import check_frames
from sessions.errors import Refused
from sessions.records.fields import Float64

_BLOCK_BYTES = 512
_MAGIC = 0x50
_MOST_POINTS = 4096
_ORDERS = {84: "<", 86: ">"}  # Intel and MIPS; DEC's floats are no IEEE numbers
_BYTES = {-1: 1, 1: 1, 2: 2, 4: 4}  # of each type of parameter: letters, byte, integer, float


@dataclass(frozen=True, slots=True)
class C3dPoints:
    """The points of a C3D file, as they stand there.

    Attributes:
        labels: Labels as written, fewer or more than there are points.
        unit: Unit of the coordinates as written, empty if missing.
        rate_hz: Frames per second as written.
        p: Coordinates in that unit, shape (N, P, 3).
        residual: Below 0 where a point is not known, shape (N, P).
    """

    labels: tuple[str, ...]
    unit: str
    rate_hz: float
    p: Float64
    residual: Float64


def read_points(path: Path) -> C3dPoints:
    """Read the points of a C3D file.

    Raises:
        Refused: It is no C3D file, or shorter than it states.
    """
    held = path.read_bytes()
    if len(held) < _BLOCK_BYTES or held[1] != _MAGIC or held[0] < 2:
        raise Refused(f"recording {path.name}", "no C3D file", "a C3D export", "export it as C3D")
    at = _BLOCK_BYTES * (held[0] - 1)
    if at + 4 > len(held):
        raise _cut(path)
    order = _ORDERS.get(held[at + 3])
    if order is None:
        raise Refused(
            f"recording {path.name}",
            f"of processor type {held[at + 3]}",
            "84 (Intel) or 86 (MIPS)",
            "export it again as Intel C3D",
        )
    point = _point_group(path, held[at + 4 :], order)
    p, residual = _frames(path, held, order)
    labels = [
        label for number in range(1, 18) for label in _texts(point, f"LABELS{number if number > 1 else ''}")
    ]
    rate = point.get("RATE")
    header_hz = float(np.frombuffer(held, f"{order}f4", 1, 20)[0])
    rate_hz = (
        float(rate.ravel()[0]) if rate is not None and rate.dtype.kind == "f" and rate.size else header_hz
    )
    return C3dPoints(tuple(labels), "".join(_texts(point, "UNITS")[:1]), rate_hz, p, residual)


def _frames(path: Path, held: bytes, order: str) -> tuple[Float64, Float64]:
    """Coordinates and residuals of every frame; the analog values between frames are passed over."""
    words = np.frombuffer(held, f"{order}u2", 9)
    points, analog, first, last, start = (int(words[at]) for at in (1, 2, 3, 4, 8))
    scale = float(np.frombuffer(held, f"{order}f4", 1, 12)[0])
    if not 0 < points <= _MOST_POINTS:
        raise Refused(
            f"recording {path.name}", f"of {points} markers", f"1 to {_MOST_POINTS}", "export its markers"
        )
    if not np.isfinite(scale) or scale == 0:
        raise Refused(f"recording {path.name}", f"of scale {scale:g}", "finite, not 0", "export it again")
    frames = last - first + 1
    if frames < 1:
        raise _cut(path)
    check_frames(path, frames)
    kind = np.dtype(f"{order}f4" if scale < 0 else f"{order}i2")
    begin, width = _BLOCK_BYTES * (start - 1), 4 * points + analog
    if start < 2 or begin + frames * width * kind.itemsize > len(held):
        raise _cut(path)
    raw = np.frombuffer(held, kind, frames * width, begin).reshape(frames, width)[:, : 4 * points]
    with np.errstate(invalid="ignore"):
        values = raw.reshape(frames, points, 4).astype(np.float64)
    factor = 1.0 if scale < 0 else scale
    return factor * values[..., :3], values[..., 3]


def _point_group(path: Path, block: bytes, order: str) -> dict[str, np.ndarray]:
    """The parameters of group POINT by name: float64 arrays, or bytes of shape (texts, letters)."""
    groups: dict[str, int] = {}
    found: list[tuple[int, str, np.ndarray]] = []
    at = 0
    while at + 2 <= len(block) and block[at]:
        length, number = abs(_signed(block[at])), _signed(block[at + 1])
        name = block[at + 2 : at + 2 + length].decode("latin-1").upper()
        after = at + 2 + length
        if after + 2 > len(block):
            raise _cut(path)
        step = int(np.frombuffer(block, f"{order}i2", 1, after)[0])
        if number < 0:
            groups[name] = -number
        else:
            found.append((number, name, _parameter(path, block, after + 2, order)))
        if step <= 0:  # the last one
            break
        at = after + step
    wanted = groups.get("POINT")
    return {name: value for number, name, value in found if number == wanted}


def _parameter(path: Path, block: bytes, at: int, order: str) -> np.ndarray:
    kind, count = _signed(_byte(path, block, at)), _byte(path, block, at + 1)
    shape = tuple(block[at + 2 : at + 2 + count])
    if kind not in _BYTES:
        raise Refused(
            f"recording {path.name}", f"with a parameter of type {kind}", "-1, 1, 2 or 4", "export it again"
        )
    size, begin = int(np.prod(shape, dtype=np.int64)), at + 2 + count
    if len(shape) < count or begin + size * _BYTES[kind] > len(block) or size < 0:
        raise _cut(path)
    if kind == -1:
        letters = np.frombuffer(block, np.uint8, size, begin)
        return letters.reshape(-1, shape[0]) if shape and shape[0] else letters.reshape(1, -1)
    if kind == 1:
        return np.frombuffer(block, np.uint8, size, begin)
    return np.frombuffer(block, f"{order}i2" if kind == 2 else f"{order}f4", size, begin).astype(
        np.int64 if kind == 2 else np.float64
    )


def _texts(point: dict[str, np.ndarray], name: str) -> list[str]:
    rows = point.get(name)
    if rows is None or rows.ndim != 2:
        return []
    return [row.tobytes().decode("utf-8", "replace").strip(" \0") for row in rows]


def _byte(path: Path, block: bytes, at: int) -> int:
    if at >= len(block):
        raise _cut(path)
    return block[at]


def _signed(byte: int) -> int:
    return byte - 256 if byte > 127 else byte


def _cut(path: Path) -> Refused:
    return Refused(f"recording {path.name}", "shorter than it states", "a whole C3D file", "export it again")
