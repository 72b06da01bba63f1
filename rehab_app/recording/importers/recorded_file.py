"""What every importer gives, and what every imported file must be before it is opened."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from rehab_app.hand.series import LandmarkSeries
from rehab_app.recording.take import SHORTEST_S
from sessions.errors import Refused
from sessions.records.fields import Float64

MOST_BYTES = 256 << 20
MOST_FRAMES = 60_000
LARGEST_M = 100.0
"""Coordinates beyond this are not those of a hand before a camera."""


@dataclass(frozen=True, slots=True)
class RecordedFile:
    """A recording as it was read.

    Attributes:
        source: Kind of file, as session files carry it, such as "qualisys-tsv".
        series: All named points of it, in m, gaps as NaN.
        utc_start_ns: When it was recorded, None where the file does not say.
        shortest_s: What it must last at least, s.
    """

    source: str
    series: LandmarkSeries
    utc_start_ns: int | None
    shortest_s: float = SHORTEST_S


def check_readable(path: Path) -> None:
    """Refuse what is no file of a sane size.

    Raises:
        Refused: There is no such file, it cannot be read, is empty or too large.
    """
    try:
        if not path.is_file():
            raise Refused("recording", repr(str(path)), "a file that exists", "check the path")
        size = path.stat().st_size
        with path.open("rb"):
            pass
    except OSError as error:
        raise Refused(
            f"recording {path.name}", f"unreadable ({error.strerror})", "readable", "check its permissions"
        ) from error
    if not 0 < size <= MOST_BYTES:
        raise Refused(
            f"recording {path.name}",
            f"{size} bytes long",
            f"1 to {MOST_BYTES} bytes",
            "export it again, in shorter parts if it is long",
        )


def check_frames(path: Path, frames: int) -> None:
    """Refuse more frames than fit a take.

    Raises:
        Refused: There are none or too many.
    """
    if not 0 < frames <= MOST_FRAMES:
        raise Refused(
            f"recording {path.name}",
            f"{frames} frames long",
            f"1 to {MOST_FRAMES} frames",
            "export a part of it",
        )


def table_of(path: Path, rows: Sequence[Sequence[str]]) -> Float64:
    """Rows of text fields as numbers, NaN where a field is empty, shape (N, K).

    Raises:
        Refused: A field is no number, or infinite.
    """
    try:
        table = np.array([[field.strip() or "nan" for field in row] for row in rows], dtype=np.float64)
    except ValueError as error:
        raise Refused(
            f"recording {path.name}", f"not all numbers ({error})", "numbers or empty", "export it again"
        ) from error
    if bool(np.isinf(table).any()):
        raise Refused(f"recording {path.name}", "infinite in places", "numbers or empty", "export it again")
    return table
