"""Marker protocols as data: which marker rides on which bone, over which landmark, how surely placed."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np

from sessions.errors import Refused
from sessions.records.fields import Float64, Int64
from sessions.records.names import FINGERS, LANDMARKS

PROTOCOLS = ("thesis25", "mocap13", "mediapipe21", "leap20", "fingertips5", "finger_thumb8")
SEEN_PROTOCOLS = tuple(name for name in PROTOCOLS if name != "leap20")
"""Those whose markers are points in a picture; what a Leap Motion gives are joints that it has reckoned."""
"""Names of the protocols that come with the application."""

SEGMENTS: tuple[str, ...] = (
    *(f"thumb_{bone}" for bone in ("metacarpal", "proximal", "distal")),
    *(f"{finger}_{bone}" for finger in FINGERS for bone in ("proximal", "middle", "distal")),
    "palm",
)
"""The 16 rigid parts of a hand: three bones of each digit, in the order of DIGITS, then the palm."""

_MOST_BYTES = 1 << 18
_MOST_MARKERS = 64
_FARTHEST_M = 0.1
_FIELDS = ("name", "description", "noise_m", "size_std", "marker")
_MARKER_FIELDS = ("name", "segment", "anchor", "offset_m", "offset_std_m", "colour", "links")
_SMALL = (0.003, 0.003, 0.003)


@dataclass(frozen=True, slots=True)
class Marker:
    """One marker and where it belongs.

    Attributes:
        name: Marker name, as recordings carry it.
        segment: What it rides on, one of SEGMENTS.
        anchor: Landmark that its offset starts from.
        offset_m: Place relative to the anchor in the segment's axes (palmar, radial, distal; right hand).
        offset_std_m: How surely that is known before calibration, per axis.
        colour: Colour to look for, empty where none matters.
        links: Markers that a picture joins to this one by a line.
    """

    name: str
    segment: str
    anchor: str
    offset_m: tuple[float, float, float]
    offset_std_m: tuple[float, float, float]
    colour: str = ""
    links: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class MarkerProtocol:
    """A set of markers, in the order of every array over markers.

    Attributes:
        name: Protocol name, as files carry it.
        description: One line for a person.
        markers: The M markers.
        noise_m: Usual standard deviation of a position per axis, skin motion included.
        size_std: How much the whole hand's size wavers from frame to frame, as a share; 0 for real markers,
            above it for landmarks that a network guessed without a metric scale.

    Raises:
        Refused: No markers, too many, a name twice, or a part of the hand that does not exist.
    """

    name: str
    description: str
    markers: tuple[Marker, ...]
    noise_m: float = 0.002
    size_std: float = 0.0

    def __post_init__(self) -> None:
        where, mend = f"marker protocol {self.name}", "mend the protocol file"
        if not 3 <= len(self.markers) <= _MOST_MARKERS:
            raise Refused(where, f"of {len(self.markers)} markers", f"3 to {_MOST_MARKERS} markers", mend)
        if len(set(self.names)) != len(self.markers):
            raise Refused(where, "naming a marker twice", "of distinct names", mend)
        for marker in self.markers:
            if marker.segment not in SEGMENTS:
                raise Refused(
                    f"{where}, {marker.name}", repr(marker.segment), "on " + ", ".join(SEGMENTS), mend
                )
            if marker.anchor not in LANDMARKS:
                raise Refused(f"{where}, {marker.name}", repr(marker.anchor), "anchored at a landmark", mend)
            if not (min(marker.offset_std_m) > 0 and max(marker.offset_std_m) <= _FARTHEST_M):
                raise Refused(
                    f"{where}, {marker.name}, offset_std_m",
                    str(list(marker.offset_std_m)),
                    f"above 0 to {_FARTHEST_M} m",
                    mend,
                )
            if not max(abs(edge) for edge in marker.offset_m) <= _FARTHEST_M:
                raise Refused(
                    f"{where}, {marker.name}, offset_m",
                    str(list(marker.offset_m)),
                    f"within {_FARTHEST_M} m of its landmark",
                    f"{mend} (lengths are in metres)",
                )
            for link in marker.links:
                if link not in self.names:
                    raise Refused(
                        f"{where}, {marker.name}", f"linked to {link!r}", "linked to its markers", mend
                    )
        if not (self.noise_m > 0 and 0 <= self.size_std <= 1):
            raise Refused(where, f"of noise {self.noise_m:g} m", "above 0 m, size_std 0 to 1", mend)

    @property
    def names(self) -> tuple[str, ...]:
        """Marker names in order."""
        return tuple(marker.name for marker in self.markers)

    @property
    def offsets_m(self) -> Float64:
        """Offsets before calibration, shape (M, 3)."""
        return np.array([marker.offset_m for marker in self.markers], dtype=np.float64)

    @property
    def offset_stds_m(self) -> Float64:
        """How surely each offset is known, shape (M, 3)."""
        return np.array([marker.offset_std_m for marker in self.markers], dtype=np.float64)

    @property
    def segments(self) -> Int64:
        """Index into SEGMENTS of each marker, shape (M,)."""
        return np.array([SEGMENTS.index(marker.segment) for marker in self.markers], dtype=np.int64)

    @property
    def anchors(self) -> Int64:
        """Index into LANDMARKS of each marker's anchor, shape (M,)."""
        return np.array([LANDMARKS.index(marker.anchor) for marker in self.markers], dtype=np.int64)


def load_protocol(name_or_path: str | Path) -> MarkerProtocol:
    """A protocol by its name, or from a TOML file.

    Raises:
        Refused: There is no such protocol or file, or the file does not state one.
    """
    if str(name_or_path) in PROTOCOLS:
        text = (resources.files("web_assets") / "protocols" / f"{name_or_path}.toml").read_text("utf-8")
        return _parse(text, str(name_or_path))
    path = Path(name_or_path)
    if path.suffix != ".toml" or not path.is_file():
        known = ", ".join(PROTOCOLS)
        raise Refused("marker protocol", repr(str(name_or_path)), f"{known} or a .toml file", "choose one")
    if path.stat().st_size > _MOST_BYTES:
        raise Refused(
            "marker protocol", f"{path.stat().st_size} bytes", f"at most {_MOST_BYTES}", "shorten it"
        )
    try:
        return _parse(path.read_text("utf-8"), path.name)
    except (UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise Refused(
            f"marker protocol {path.name}", "no TOML", "TOML in UTF-8", f"mend it: {error}"
        ) from error


def _parse(text: str, source: str) -> MarkerProtocol:
    where = f"marker protocol {source}"
    table: dict[str, Any] = tomllib.loads(text)
    _known(table, _FIELDS, where)
    rows: Any = table.get("marker")
    if not isinstance(rows, list) or not all(isinstance(row, dict) for row in rows):
        raise Refused(where, "without markers", "a list of [[marker]] tables", "write one for each marker")
    return MarkerProtocol(
        _text(table, "name", where),
        _text(table, "description", where, ""),
        tuple(_marker(row, f"{where}, marker {number}") for number, row in enumerate(rows, 1)),
        _number(table, "noise_m", where, 0.002),
        _number(table, "size_std", where, 0.0),
    )


def _marker(row: dict[str, Any], where: str) -> Marker:
    if isinstance(row.get("name"), str):
        where = f"{where} ({row['name']})"
    _known(row, _MARKER_FIELDS, where)
    links: Any = row.get("links", [])
    if not isinstance(links, list):
        raise Refused(f"{where}, links", repr(links), "a list of marker names", "mend the protocol file")
    return Marker(
        _text(row, "name", where),
        _text(row, "segment", where),
        _text(row, "anchor", where),
        _triple(row, "offset_m", where, (0.0, 0.0, 0.0)),
        _triple(row, "offset_std_m", where, _SMALL),
        _text(row, "colour", where, ""),
        tuple(str(link) for link in links),
    )


def _known(table: dict[str, Any], fields: tuple[str, ...], where: str) -> None:
    """Refuse a field that would be ignored: most likely it is misspelt."""
    for field in table:
        if field not in fields:
            raise Refused(where, f"with a field {field!r}", "of " + ", ".join(fields), "rename or remove it")


def _text(table: dict[str, Any], field: str, where: str, default: str | None = None) -> str:
    value: Any = table.get(field, default)
    if not isinstance(value, str) or (default is None and not value.strip()):
        met = "missing" if value is None else repr(value)
        raise Refused(f"{where}, {field}", met, "a text in quotes", "mend the protocol file")
    return value


def _number(table: dict[str, Any], field: str, where: str, default: float) -> float:
    return _finite(table.get(field, default), f"{where}, {field}")


def _triple(
    table: dict[str, Any], field: str, where: str, default: tuple[float, float, float]
) -> tuple[float, float, float]:
    value: Any = table.get(field, default)
    if not isinstance(value, list | tuple) or len(value) != 3:
        raise Refused(
            f"{where}, {field}",
            repr(value),
            "three numbers: palmar, radial, distal",
            "mend the protocol file",
        )
    x, y, z = (_finite(number, f"{where}, {field}") for number in value)
    return x, y, z


def _finite(value: Any, where: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not np.isfinite(value):
        raise Refused(where, repr(value), "a finite number", "mend the protocol file")
    return float(value)
