"""Landmark arrays in MediaPipe order: ``landmarks_m`` (N, 21, 3); ``t_s`` (N,) or ``fps`` if not 30 Hz."""

from __future__ import annotations

import math
import tokenize
import zipfile
import zlib
from pathlib import Path
from typing import IO

import numpy as np

from rehab_app.hand.protocol import load_protocol
from rehab_app.hand.series import LandmarkSeries
from rehab_app.recording.importers.recorded_file import LARGEST_M, MOST_BYTES, RecordedFile, check_frames
from sessions.errors import Refused
from sessions.records.fields import Float64

_USUAL_HZ = 30.0
_POINTS = 21


def read_mediapipe(path: Path) -> RecordedFile:
    """Read an ``.npz`` of landmarks.

    Raises:
        Refused: It is no such archive, holds pickles, lacks the array, or the array is not that of hands.
    """
    arrays = _arrays(path)
    if "landmarks_m" not in arrays:
        held = ", ".join(sorted(arrays)) or "nothing"
        raise Refused(
            f"recording {path.name}", f"holding {held}", "landmarks_m (N, 21, 3)", "name the array so"
        )
    p_m = arrays["landmarks_m"]
    if p_m.ndim != 3 or p_m.shape[1:] != (_POINTS, 3):
        raise Refused(
            f"recording {path.name}", f"of shape {p_m.shape}", "(N, 21, 3)", "keep MediaPipe's order"
        )
    check_frames(path, len(p_m))
    if bool(np.isinf(p_m).any()) or float(np.nanmax(np.abs(p_m), initial=0.0)) > LARGEST_M:
        raise Refused(f"recording {path.name}", "infinite or beyond 100 m", "in m", "convert it to m")
    t_s = _times(path, arrays, len(p_m))
    names = load_protocol("mediapipe21").names
    gap = ~np.isfinite(p_m).all(axis=2)
    p_m[gap] = np.nan
    return RecordedFile("mediapipe-landmarks", LandmarkSeries(t_s, names, p_m), None)


def _times(path: Path, arrays: dict[str, Float64], frames: int) -> Float64:
    if "t_s" in arrays:
        t_s = arrays["t_s"]
        if t_s.shape != (frames,):
            raise Refused(f"recording {path.name}, t_s", f"of shape {t_s.shape}", f"({frames},)", "mend t_s")
        return t_s
    rate = arrays.get("fps", np.array(_USUAL_HZ)).ravel()
    if rate.size != 1 or not 1.0 <= float(rate[0]) <= 1000.0:
        raise Refused(f"recording {path.name}, fps", str(rate[:3]), "one number, 1 to 1000", "mend fps")
    return np.arange(frames) / float(rate[0])


def _arrays(path: Path) -> dict[str, Float64]:
    """The numeric arrays of an archive; sizes are checked before anything is unpacked."""
    try:
        with zipfile.ZipFile(path) as archive:
            members = [item for item in archive.infolist() if item.filename.endswith(".npy")]
            if sum(item.file_size for item in members) > MOST_BYTES:
                raise Refused(
                    f"recording {path.name}", "too large", f"{MOST_BYTES} bytes", "export a part of it"
                )
            arrays: dict[str, Float64] = {}
            for item in members:
                with archive.open(item) as stream:
                    arrays[item.filename.removesuffix(".npy")] = _array(path, stream, item.file_size)
            return arrays
    except (zipfile.BadZipFile, zlib.error, EOFError, OSError, NotImplementedError, RuntimeError) as error:
        raise Refused(
            f"recording {path.name}", "no whole .npz", "a NumPy archive", "save it again"
        ) from error


def _array(path: Path, stream: IO[bytes], size: int) -> Float64:
    """One array, as float64; its header must agree with the bytes that follow it."""
    where = f"recording {path.name}"
    try:
        version = np.lib.format.read_magic(stream)
        if version == (1, 0):
            shape, fortran, kind = np.lib.format.read_array_header_1_0(stream)
        else:
            shape, fortran, kind = np.lib.format.read_array_header_2_0(stream)
    except (ValueError, EOFError, SyntaxError, tokenize.TokenError) as error:
        raise Refused(where, "of unreadable arrays", "plain NumPy arrays", "save it again") from error
    if kind.kind not in "fiu":
        raise Refused(
            where, f"holding {kind} (a pickle is never opened)", "real numbers", "save plain numbers"
        )
    count = math.prod(shape)
    if not 0 <= count * kind.itemsize <= size:
        raise Refused(where, f"stating shape {shape}", f"{size} bytes of numbers", "save it again")
    raw = stream.read(count * kind.itemsize)
    if len(raw) != count * kind.itemsize:
        raise Refused(where, "cut", "whole", "save it again")
    flat = np.frombuffer(raw, dtype=kind)
    return flat.reshape(shape, order="F" if fortran else "C").astype(np.float64)
