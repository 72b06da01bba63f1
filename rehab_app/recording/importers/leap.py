"""Leap Motion recordings of the browser's playback library: twenty joints of a hand in mm, no wrist.

Two layouts, one meaning: each frame an object, or (format 2) rows of values after one row that names them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, TypeAlias, cast

import numpy as np

from rehab_app.hand.series import LandmarkSeries
from rehab_app.recording.importers.leap_text import read_document
from rehab_app.recording.importers.recorded_file import LARGEST_M, RecordedFile, check_frames
from sessions.errors import Refused
from sessions.records import SIDES, Side
from sessions.records.fields import Float64
from sessions.records.names import DIGITS, LANDMARKS

SOURCE = "leap-motion"
SUFFIXES = (".lz", ".json")
"""Suffixes of the pressed and of the plain form."""
NAMES: tuple[str, ...] = LANDMARKS[:20]
"""The joints that every frame has: four of each digit, in the order of protocol leap20."""

SHORTEST_S = 0.5
"""A gesture that was once recorded cannot be made longer; half a second can still be measured."""

_KEYS = ("mcpPosition", "pipPosition", "dipPosition", "tipPosition")
_M_PER_MM = 1e-3
_S_PER_US = 1e-6
# The device lies on the table and looks up: its y is the camera's depth, its -z the picture's down.
_CAMERA_FROM_LEAP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])

_Object: TypeAlias = Mapping[str, Any]


def read_leap(path: Path, side: Side | None) -> tuple[RecordedFile, Side]:
    """Read one hand of a recording; frames without that hand are gaps.

    Leap calls the thumb's joints by a finger's names: its "mcp" is the base of the thumb (``thumb_cmc``), its
    "pip" ``thumb_mcp`` and its "dip" ``thumb_ip``.

    Args:
        path: A ``.json.lz`` or ``.json`` file.
        side: The hand to take, None for the only one in the file.

    Returns:
        The recording, and the side of the hand that was taken.

    Raises:
        Refused: It is no such file, lacks joints or hands, or shows both hands and none was named.
    """
    document = read_document(path)
    try:
        frames = _frames(path, document)
        check_frames(path, len(frames))
        hands = [_hands(frame) for frame in frames]
        t_s = _S_PER_US * np.array([float(frame["timestamp"]) for frame in frames])
        chosen = _side(path, {kind for held in hands for kind, _ in held}, side)
        p_mm = np.stack(
            [_joints(path, frame, held, chosen) for frame, held in zip(frames, hands, strict=True)]
        )
    except (KeyError, TypeError, ValueError, IndexError, OverflowError) as error:
        raise Refused(
            f"recording {path.name}",
            "without the hands, joints or times of a Leap recording",
            "recorded with joints (service 2 or later)",
            "record it again",
        ) from error
    p_m = _M_PER_MM * p_mm @ _CAMERA_FROM_LEAP.T
    if bool(np.isinf(p_m).any()) or float(np.nanmax(np.abs(p_m))) > LARGEST_M:
        raise Refused(f"recording {path.name}", "beyond 100 m", "in mm, within 100 m", "record it again")
    return RecordedFile(SOURCE, LandmarkSeries(t_s - t_s[0], NAMES, p_m), None, SHORTEST_S), chosen


def _frames(path: Path, document: Any) -> list[_Object]:
    """The frames as objects, whichever layout they are kept in."""
    frames: Any = cast("_Object", document).get("frames") if isinstance(document, Mapping) else None
    if not isinstance(frames, list) or not frames:
        raise Refused(
            f"recording {path.name}", "without frames", "a Leap Motion recording", "record it again"
        )
    rows = cast("list[Any]", frames)
    if isinstance(rows[0], list):
        return [_unpacked(path, cast("list[Any]", rows[0]), row) for row in rows[1:]]
    if not all(isinstance(row, Mapping) for row in rows):
        raise _damaged(path)
    return rows


def _unpacked(path: Path, keys: Sequence[Any], row: Any) -> _Object:
    """A row of values by the row that names them; ``{"hands": [[...]]}`` names those of a list of rows."""
    if not isinstance(row, list) or len(cast("list[Any]", row)) != len(keys):
        raise _damaged(path)
    found: dict[str, Any] = {}
    for key, value in zip(keys, cast("list[Any]", row), strict=True):
        if isinstance(key, str):
            found[key] = value
            continue
        if not isinstance(key, Mapping):
            raise _damaged(path)
        for name, inner in cast("_Object", key).items():
            nested = isinstance(inner, list) and bool(inner) and isinstance(inner[0], list)
            found[name] = [_unpacked(path, inner[0], each) for each in value] if nested else value
    return found


def _hands(frame: _Object) -> list[tuple[Side, int]]:
    """Side and number of each hand of a frame."""
    found: list[tuple[Side, int]] = []
    for hand in frame["hands"]:
        kinds: list[Side] = [side for side in SIDES if side == hand["type"]]
        found.append((kinds[0], int(hand["id"])))
    return found


def _side(path: Path, seen: set[Side], asked: Side | None) -> Side:
    where = f"recording {path.name}"
    if not seen:
        raise Refused(where, "without a hand", "of a hand", "record it again with the hand over the device")
    if asked is not None:
        if asked not in seen:
            raise Refused(where, f"of the {min(seen)} hand only", f"of the {asked} one", "give its --side")
        return asked
    if len(seen) > 1:
        raise Refused(where, "of both hands", "of one", "name the hand with --side left or --side right")
    return min(seen)


def _joints(path: Path, frame: _Object, hands: list[tuple[Side, int]], side: Side) -> Float64:
    """The joints of the chosen hand in the device's axes, mm, shape (20, 3); NaN where it is not seen."""
    p_mm = np.full((len(DIGITS), len(_KEYS), 3), np.nan)
    numbers = [number for kind, number in hands if kind == side]
    if len(numbers) > 1:
        raise Refused(
            f"recording {path.name}", f"of two {side} hands at once", "of one", "record one person alone"
        )
    for digit in frame["pointables"]:
        if digit["handId"] in numbers and not digit["tool"]:
            row = int(digit["type"]) if "type" in digit else int(digit["id"]) % 10
            for column, key in enumerate(_KEYS):
                p_mm[row, column] = np.array(digit[key], dtype=np.float64).reshape(3)
    return p_mm.reshape(-1, 3)


def _damaged(path: Path) -> Refused:
    return Refused(
        f"recording {path.name}", "of frames that do not agree", "a Leap Motion recording", "record it again"
    )
