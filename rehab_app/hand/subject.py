"""One person's hand and where the markers sit on it; how both lie in a session file."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from rehab_app.hand.protocol import MarkerProtocol
from robot_iface.kinematics import HandGeometry, average_hand
from sessions.errors import Refused
from sessions.records import Side
from sessions.records.fields import Float64

_PARTS = ("bases_m", "base_rotation", "bones_m", "palm_m")


@dataclass(frozen=True, slots=True)
class Subject:
    """A person's hand, wearing the markers of a protocol.

    Attributes:
        geometry: Bone lengths and bases.
        marker_names: The M markers, in the order of their protocol.
        marker_offset_m: Offset of each from its anchor in its segment's axes, shape (M, 3).
        residual_m: rms distance of fitted from observed markers in calibration, NaN if uncalibrated.

    Raises:
        Refused: The offsets do not belong to the markers.
    """

    geometry: HandGeometry
    marker_names: tuple[str, ...]
    marker_offset_m: Float64
    residual_m: float = float("nan")

    def __post_init__(self) -> None:
        shape = (len(self.marker_names), 3)
        if self.marker_offset_m.shape != shape or not bool(np.isfinite(self.marker_offset_m).all()):
            raise Refused(
                "marker offsets",
                f"of shape {self.marker_offset_m.shape}",
                f"finite, {shape}",
                "calibrate again",
            )


def average_subject(protocol: MarkerProtocol, side: Side, length_m: float = 0.189) -> Subject:
    """The hand of average proportions with the markers where the protocol says; where calibration starts."""
    return Subject(average_hand(length_m, side), protocol.names, protocol.offsets_m)


def on_side(geometry: HandGeometry, side: Side) -> HandGeometry:
    """The same hand, or its mirror image when the side differs; joint angles keep their meaning."""
    return replace(geometry, side=side)


def geometry_to_json(geometry: HandGeometry) -> str:
    """A hand's geometry as it lies in ``SessionHeader.subject_hand``: SI, one JSON object."""
    return json.dumps(_geometry_table(geometry), sort_keys=True)


def subject_to_json(subject: Subject) -> str:
    """The geometry with the markers' places beside it; ``geometry_from_json`` reads it just as well."""
    table = _geometry_table(subject.geometry)
    table["marker_names"] = list(subject.marker_names)
    table["marker_offset_m"] = subject.marker_offset_m.tolist()
    if np.isfinite(subject.residual_m):
        table["calibration_residual_m"] = subject.residual_m
    return json.dumps(table, sort_keys=True)


def geometry_from_json(text: str) -> HandGeometry:
    """The geometry in a header.

    Raises:
        Refused: The text is not that of a hand (RobotRefused where the numbers are those of no hand).
    """
    return _geometry(_table(text))


def subject_from_json(text: str) -> Subject:
    """The subject in a header.

    Raises:
        Refused: The text is not that of a hand with markers.
    """
    table = _table(text)
    try:
        offsets = np.asarray(table["marker_offset_m"], dtype=np.float64)
        names = tuple(str(name) for name in table["marker_names"])
        residual_m = float(table.get("calibration_residual_m", np.nan))
    except (KeyError, TypeError, ValueError) as error:
        raise _unreadable(str(error)) from error
    return Subject(_geometry(table), names, offsets, residual_m)


def _geometry_table(geometry: HandGeometry) -> dict[str, Any]:
    table: dict[str, Any] = {name: getattr(geometry, name).tolist() for name in _PARTS}
    return {"side": geometry.side, **table}


def _table(text: str) -> Mapping[str, Any]:
    try:
        table: Any = json.loads(text)
    except (json.JSONDecodeError, RecursionError) as error:
        raise _unreadable(str(error)) from error
    if not isinstance(table, dict):
        raise _unreadable("no object")
    return table


def _geometry(table: Mapping[str, Any]) -> HandGeometry:
    try:
        arrays = [np.asarray(table[name], dtype=np.float64) for name in _PARTS]
    except (KeyError, TypeError, ValueError) as error:
        raise _unreadable(str(error)) from error
    side = table.get("side")
    if side not in ("left", "right"):
        raise _unreadable(f"side {side!r}")
    return HandGeometry("left" if side == "left" else "right", *arrays)


def _unreadable(why: str) -> Refused:
    return Refused(
        "hand geometry", f"unreadable ({why})", "JSON of a hand", "record or import the take again"
    )
