"""Landmark arrays in MediaPipe order: ``landmarks_m`` (N, 21, 3); ``t_s`` (N,) or ``fps`` if not 30 Hz."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from rehab_app.hand.protocol import load_protocol
from rehab_app.hand.series import LandmarkSeries
from rehab_app.recording.archive import Archive
from rehab_app.recording.importers.recorded_file import LARGEST_M, RecordedFile, check_frames
from sessions.errors import Refused
from sessions.records.fields import Float64

_USUAL_HZ = 30.0
_POINTS = 21


def read_mediapipe(path: Path) -> RecordedFile:
    """Read an ``.npz`` of landmarks.

    Raises:
        Refused: It is no such archive, holds pickles, lacks the array, or the array is not that of hands.
    """
    held = Archive(path)
    p_m = held.numbers("landmarks_m")
    if p_m.ndim != 3 or p_m.shape[1:] != (_POINTS, 3):
        raise Refused(
            f"recording {path.name}", f"of shape {p_m.shape}", "(N, 21, 3)", "keep MediaPipe's order"
        )
    check_frames(path, len(p_m))
    if bool(np.isinf(p_m).any()) or float(np.nanmax(np.abs(p_m), initial=0.0)) > LARGEST_M:
        raise Refused(f"recording {path.name}", "infinite or beyond 100 m", "in m", "convert it to m")
    t_s = _times(path, held, len(p_m))
    names = load_protocol("mediapipe21").names
    gap = ~np.isfinite(p_m).all(axis=2)
    p_m[gap] = np.nan
    return RecordedFile("mediapipe-landmarks", LandmarkSeries(t_s, names, p_m), None)


def _times(path: Path, held: Archive, frames: int) -> Float64:
    if "t_s" in held:
        t_s = held.numbers("t_s")
        if t_s.shape != (frames,):
            raise Refused(f"recording {path.name}, t_s", f"of shape {t_s.shape}", f"({frames},)", "mend t_s")
        return t_s
    rate = held.numbers("fps").ravel() if "fps" in held else np.array([_USUAL_HZ])
    if rate.size != 1 or not 1.0 <= float(rate[0]) <= 1000.0:
        raise Refused(f"recording {path.name}, fps", str(rate[:3]), "one number, 1 to 1000", "mend fps")
    return np.arange(frames) / float(rate[0])
