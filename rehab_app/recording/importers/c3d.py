"""C3D, as Vicon and other motion capture export it: labelled 3-D markers; a gap has a residual below 0."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from rehab_app.hand.series import LandmarkSeries
from rehab_app.recording.importers.c3d_file import C3dPoints, read_points
from rehab_app.recording.importers.recorded_file import LARGEST_M, RecordedFile
from sessions.errors import Refused
from sessions.records import LANDMARKS

_M_PER_UNIT = {"mm": 1e-3, "cm": 1e-2, "m": 1.0}
_FASTEST_HZ = 10_000.0
_DIGITS = {"1": "thumb", "2": "index", "3": "middle", "4": "ring", "5": "little"}
_JOINT_AND_DIGIT = re.compile(r"(cmc|mcp|pip|dip|ip|tip)_?([1-5])")


def read_c3d(path: Path) -> RecordedFile:
    """Read the labelled markers of a C3D file.

    Labels are brought to this application's form: the person before a colon is dropped, letters become
    small, spaces underscores; ``MCP2`` of the thesis's Figure 3.9 is ``index_mcp``. What capture left
    unlabelled (``*12``) is left out. A file without a unit is taken as in mm, which Vicon writes.

    Raises:
        Refused: It is no C3D file, cut, without labels, rate or a known unit, or beyond 100 m.
    """
    held = read_points(path)
    labels = _labels(path, held)
    p_m = _m_per_unit(path, held.unit) * held.p
    empty = ~(held.residual >= 0) | ~np.isfinite(p_m).all(axis=2) | (p_m == 0).all(axis=2)
    p_m[empty] = np.nan
    if bool((np.abs(p_m[~empty]) > LARGEST_M).any()):
        raise Refused(f"recording {path.name}", "beyond 100 m", "within 100 m", "export it in its true unit")
    if not 1.0 <= held.rate_hz <= _FASTEST_HZ:
        raise Refused(
            f"recording {path.name}", f"at {held.rate_hz:g} Hz", f"1 to {_FASTEST_HZ:g} Hz", "export it again"
        )
    kept = [column for column, label in enumerate(labels) if label]
    names = tuple(labels[column] for column in kept)
    t_s = np.arange(len(p_m)) / held.rate_hz
    return RecordedFile("c3d", LandmarkSeries(t_s, names, p_m[:, kept]), None)


def _labels(path: Path, held: C3dPoints) -> list[str]:
    """A name for each point, empty where it has none."""
    points = held.p.shape[1]
    found = ([_landmark(label) for label in held.labels] + [""] * points)[:points]
    named = [label for label in found if label]
    if not named:
        raise Refused(f"recording {path.name}", "without labels", "of labelled markers", "label the markers")
    for label in named:
        if named.count(label) > 1:
            raise Refused(
                f"recording {path.name}", f"naming {label} twice", "of distinct names", "label it again"
            )
    return found


def _landmark(label: str) -> str:
    """The application's name of a marker; what is none of ours keeps its own, in small letters."""
    plain = re.sub(r"[\s\-]+", "_", label.rpartition(":")[2].strip().lower())
    if plain.startswith("*"):
        return ""
    match = _JOINT_AND_DIGIT.fullmatch(plain)
    if plain in LANDMARKS or match is None:
        return plain
    name = f"{_DIGITS[match[2]]}_{match[1]}"
    return name if name in LANDMARKS else plain


def _m_per_unit(path: Path, stated: str) -> float:
    unit = stated.lower() or "mm"
    if unit not in _M_PER_UNIT:
        raise Refused(f"recording {path.name}", f"in {unit}", "in mm, cm or m", "export it in mm")
    return _M_PER_UNIT[unit]
