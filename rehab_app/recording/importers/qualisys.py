"""Qualisys Track Manager's TSV export: labelled 3-D markers in mm; a gap is empty or three zeros."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from rehab_app.hand.series import LandmarkSeries
from rehab_app.recording.importers.recorded_file import LARGEST_M, RecordedFile, check_frames, table_of
from sessions.errors import Refused
from sessions.records.fields import Float64

_M_PER_MM = 1e-3
_MOST_KEYS = 40  # header lines before the numbers


@dataclass(frozen=True, slots=True)
class _Header:
    names: tuple[str, ...]
    rate_hz: float
    frames: int
    utc_start_ns: int | None
    timed: bool  # whether Frame and Time columns come first
    first_line: int


def read_qualisys(path: Path) -> RecordedFile:
    """Read a TSV export.

    The time stamp of the header is taken as UTC: the file does not name its zone.

    Raises:
        Refused: The header is cut or without names, a row is cut, or a value is no number or not in mm.
    """
    lines = _lines(path)
    header = _header(path, lines)
    table = _table(path, lines, header)
    check_frames(path, len(table))
    if header.frames > len(table):
        raise Refused(
            f"recording {path.name}",
            f"cut after {len(table)} frames",
            f"{header.frames} frames",
            "export it again",
        )
    points = table[:, 2:] if header.timed else table
    p_m = _M_PER_MM * points.reshape(len(table), len(header.names), 3)
    empty = np.isnan(p_m).any(axis=2) | (p_m == 0).all(axis=2)
    p_m[empty] = np.nan
    if bool((np.abs(p_m[~empty]) > LARGEST_M).any()):
        raise Refused(f"recording {path.name}", "beyond 100 m", "in mm, within 100 m", "export it in mm")
    t_s = table[:, 1] if header.timed else np.arange(len(table)) / header.rate_hz
    return RecordedFile("qualisys-tsv", LandmarkSeries(t_s, header.names, p_m), header.utc_start_ns)


def _lines(path: Path) -> list[str]:
    try:
        text = path.read_text("utf-8-sig")
    except UnicodeDecodeError as error:
        raise Refused(
            f"recording {path.name}", "no text", "a Qualisys TSV export", "export it as TSV"
        ) from error
    return text.splitlines()


def _header(path: Path, lines: list[str]) -> _Header:
    keys: dict[str, list[str]] = {}
    line = 0
    while (
        line < min(len(lines), _MOST_KEYS) and lines[line][:1].isalpha() and not _is_column_row(lines[line])
    ):
        key, *values = lines[line].rstrip().split("\t")
        keys[key] = values
        line += 1
    names = tuple(name.strip() for name in keys.get("MARKER_NAMES", ()) if name.strip())
    if not names:
        raise Refused(
            f"recording {path.name}", "without MARKER_NAMES", "a Qualisys TSV export", "export it again"
        )
    if len(set(names)) != len(names):
        raise Refused(
            f"recording {path.name}", "naming a marker twice", "of distinct names", "label it again"
        )
    rate_hz = _number(path, keys, "FREQUENCY")
    if not 1.0 <= rate_hz <= 10_000.0:
        raise Refused(f"recording {path.name}", f"at {rate_hz:g} Hz", "1 to 10000 Hz", "export it again")
    frames = int(_number(path, keys, "NO_OF_FRAMES"))
    timed = line < len(lines) and _is_column_row(lines[line])
    return _Header(names, rate_hz, frames, _utc_ns(keys.get("TIME_STAMP", [])), timed, line + int(timed))


def _is_column_row(line: str) -> bool:
    return line.startswith("Frame\tTime\t")


def _number(path: Path, keys: dict[str, list[str]], key: str) -> float:
    try:
        value = float(keys[key][0])
    except (KeyError, IndexError, ValueError) as error:
        raise Refused(
            f"recording {path.name}", f"without a number for {key}", "a whole TSV header", "export it again"
        ) from error
    if not 0 <= value < 1e9:
        raise Refused(f"recording {path.name}", f"of {key} {value:g}", "0 to 1e9", "export it again")
    return value


def _utc_ns(stamp: list[str]) -> int | None:
    try:
        moment = datetime.strptime(stamp[0], "%Y-%m-%d, %H:%M:%S.%f").replace(tzinfo=UTC)
    except (IndexError, ValueError):
        return None
    return int(moment.timestamp() * 1000) * 1_000_000


def _table(path: Path, lines: list[str], header: _Header) -> Float64:
    """The numbers, one row per frame, NaN where a field is empty."""
    width = 3 * len(header.names) + (2 if header.timed else 0)
    rows = [line.rstrip("\r\n").split("\t") for line in lines[header.first_line :] if line.strip()]
    check_frames(path, len(rows))
    for number, row in enumerate(rows):
        while len(row) > width and not row[-1].strip():
            row.pop()
        if len(row) != width:
            raise Refused(
                f"recording {path.name}, line {header.first_line + number + 1}",
                f"of {len(row)} fields",
                f"{width} fields",
                "export it again",
            )
    return table_of(path, rows)
