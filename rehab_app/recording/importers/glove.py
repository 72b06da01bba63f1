"""A data glove of 22 sensors (thesis, Table 3.1) as CSV: angles since the first frame, to a posed hand.

One row a frame, one column a sensor in the order of Table 3.1, in degrees; before them, if the first name is
``t_s``, the time. Lines that begin with ``#`` may state ``rate_hz`` (30 unless stated) and ``hand_length_m``.
"""

from __future__ import annotations

import csv
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from rehab_app.hand.pose_fit import HandFit
from rehab_app.hand.series import LandmarkSeries
from rehab_app.hand.subject import Subject
from rehab_app.recording.importers.recorded_file import check_frames, table_of
from robot_iface.kinematics import average_hand, forward, jacobian
from sessions.errors import Refused
from sessions.records import JOINTS, LANDMARKS, Side, Status
from sessions.records.fields import Float64
from sessions.records.names import FINGERS, FINGERTIPS

SENSORS = 22
SENSOR_STD_RAD = 0.05
"""How surely a worn glove knows an angle, rad."""
UNSENSED_STD_RAD = 0.1
"""How far a joint that no sensor sits on may be from straight, rad."""

_RATE_HZ = 30.0
_LENGTH_M = 0.189
_LARGEST_RAD = np.pi
_SETTING = re.compile(r"#\s*(\w+)\s*[:=]\s*(\S+)\s*")
_BOUNDS = {"rate_hz": (1.0, 1000.0), "hand_length_m": (0.12, 0.25)}
# Sensors that a joint's angle is the sum of, with their signs. The spread sensors measure between neighbours;
# abduction here is positive to radial, and the middle finger stays.
_PARTS: dict[str, dict[int, float]] = {
    "thumb_cmc_flexion": {0: 1.0},
    "thumb_mcp_flexion": {1: 1.0},
    "thumb_ip": {2: 1.0},
    "thumb_cmc_abduction": {3: 1.0},
    **{
        f"{finger}_{joint}": {4 * row + at: 1.0}
        for row, finger in enumerate(FINGERS, 1)
        for at, joint in enumerate(("mcp_flexion", "pip", "dip"))
    },
    "index_mcp_abduction": {7: 1.0},
    "ring_mcp_abduction": {11: -1.0},
    "little_mcp_abduction": {11: -1.0, 15: -1.0},
}


@dataclass(frozen=True, slots=True)
class GloveFile:
    """A glove's recording.

    Attributes:
        t_s: Times, shape (N,).
        sensors_rad: Angles since the first whole frame, shape (N, 22), NaN where a cell was empty.
        hand_length_m: Length of the hand that wore it, as stated, else that of an average one.
    """

    t_s: Float64
    sensors_rad: Float64
    hand_length_m: float


def read_glove(path: Path) -> GloveFile:
    """Read a glove's CSV and subtract the hand at rest, its first whole frame.

    Raises:
        Refused: No text, not 22 sensors, not numbers, no whole frame, or angles that no joint turns.
    """
    settings, names, table = _table(path)
    timed = table.shape[1] == SENSORS + 1
    if timed != (names[:1] == ["t_s"]) and names:
        raise Refused(f"recording {path.name}", f"of columns {names[0]}, ...", "t_s first, or without time",
                      "name the column of times t_s")  # fmt: skip
    if timed and not np.isfinite(table[:, 0]).all():
        raise Refused(f"recording {path.name}, t_s", "empty in places", "a number in s", "export it again")
    sensors = np.deg2rad(table[:, -SENSORS:])
    whole = np.flatnonzero(np.isfinite(sensors).all(axis=1))
    if not whole.size:
        raise Refused(f"recording {path.name}", "without a whole frame", "of 22 sensors", "export it again")
    moved = sensors - sensors[whole[0]]
    farthest = float(np.nanmax(np.abs(moved)))
    if farthest > _LARGEST_RAD:
        raise Refused(
            f"recording {path.name}",
            f"{np.degrees(farthest):.0f} degrees from rest",
            "within 180 degrees",
            "export calibrated angles in degrees",
        )
    rate_hz = settings.get("rate_hz", _RATE_HZ)
    t_s = table[:, 0] if timed else np.arange(len(table)) / rate_hz
    return GloveFile(t_s, moved, settings.get("hand_length_m", _LENGTH_M))


def glove_joints(sensors_rad: Float64) -> Float64:
    """Joint angles of a glove's rest-subtracted sensors; palm arch and wrist (19 to 21) move no digit.

    Args:
        sensors_rad: Shape (N, 22), NaN where missing.

    Returns:
        Shape (N, 21), order of JOINTS; 0 where no sensor sits, NaN where its sensor is missing.
    """
    joints = np.zeros((len(sensors_rad), len(JOINTS)))
    for name, parts in _PARTS.items():
        joints[:, JOINTS.index(name)] = sum(sign * sensors_rad[:, sensor] for sensor, sign in parts.items())
    return joints


def glove_hand(glove: GloveFile, side: Side) -> tuple[LandmarkSeries, Subject, HandFit]:
    """A series without markers, the hand, and its pose: fingertips by forward kinematics.

    The glove does not know where the hand is: the take's frame is that of the palm. Joints without a sensor
    are ESTIMATED straight.
    """
    geometry = average_hand(glove.hand_length_m, side)
    joints = glove_joints(glove.sensors_rad)
    frames = len(joints)
    std = np.where([name in _PARTS for name in JOINTS], SENSOR_STD_RAD, UNSENSED_STD_RAD)
    status = np.where([name in _PARTS for name in JOINTS], Status.MEASURED, Status.ESTIMATED)
    lost = ~np.isfinite(joints)
    covariance = np.tile(np.diag(std**2), (frames, 1, 1))
    little, ring = JOINTS.index("little_mcp_abduction"), JOINTS.index("ring_mcp_abduction")
    covariance[:, little, little] = 2 * SENSOR_STD_RAD**2  # it adds two sensors, one of them the ring's
    covariance[:, little, ring] = covariance[:, ring, little] = SENSOR_STD_RAD**2
    tips = [LANDMARKS.index(name) for name in FINGERTIPS]
    slopes = jacobian(geometry, np.where(lost, 0.0, joints))[:, tips]
    tip_covariance = slopes @ covariance[:, None] @ np.swapaxes(slopes, -1, -2)
    placed = forward(geometry, joints).landmarks_m[:, tips]
    tip_covariance[~np.isfinite(placed).all(axis=2)] = np.nan
    covariance[lost[:, :, None] | lost[:, None, :]] = np.nan
    fit = HandFit(
        np.zeros((frames, 3)),
        np.tile([1.0, 0.0, 0.0, 0.0], (frames, 1)),
        joints,
        covariance,
        np.where(lost, Status.LOST, status).astype(np.uint8),
        placed,
        tip_covariance,
        np.full(frames, np.nan),
        np.ones(frames),
        np.zeros(0),
    )
    return (
        LandmarkSeries(glove.t_s, (), np.zeros((frames, 0, 3))),
        Subject(geometry, (), np.zeros((0, 3))),
        fit,
    )


def _table(path: Path) -> tuple[dict[str, float], list[str], Float64]:
    """What the comments state, the names of the columns if there are any, and the numbers."""
    try:
        lines = path.read_text("utf-8-sig").splitlines()
    except UnicodeDecodeError as error:
        raise Refused(f"recording {path.name}", "no text", "a glove's CSV", "export it as CSV") from error
    settings = _settings(path, [line for line in lines if line.startswith("#")])
    try:
        rows = [row for row in csv.reader(line for line in lines if line.strip() and line[0] != "#") if row]
    except csv.Error as error:
        raise Refused(f"recording {path.name}", f"no CSV ({error})", "a glove's CSV", "mend it") from error
    names: list[str] = []
    if rows and any(_is_name(field) for field in rows[0]):
        names = [field.strip() for field in rows.pop(0)]
    check_frames(path, len(rows))
    width = len(names) or len(rows[0])
    counted: list[list[str]] = [names, *rows] if names else rows
    for number, row in enumerate(counted, 1):
        if len(row) != width or width not in (SENSORS, SENSORS + 1):
            raise Refused(
                f"recording {path.name}, row {number}",
                f"of {len(row)} columns",
                f"{SENSORS} sensors, with t_s before them if times are stated",
                "export all sensors of Table 3.1",
            )
    return settings, names, table_of(path, rows)


def _is_name(field: str) -> bool:
    return field.strip()[:1].isalpha() and field.strip().lower() not in ("nan", "inf", "infinity")


def _settings(path: Path, comments: list[str]) -> dict[str, float]:
    found: dict[str, float] = {}
    for line in comments:
        match = _SETTING.fullmatch(line)
        if match is None or match[1] not in _BOUNDS:
            continue
        low, high = _BOUNDS[match[1]]
        try:
            value = float(match[2])
        except ValueError:
            value = float("nan")
        if not low <= value <= high:
            raise Refused(
                f"recording {path.name}, {match[1]}", match[2], f"{low:g} to {high:g}", "mend that line"
            )
        found[match[1]] = value
    return found
