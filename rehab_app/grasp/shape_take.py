"""The shape of the hand in takes, at the end of every closing of it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from rehab_app.grasp.shape import NEIGHBOURS, HandShape, hand_shape
from rehab_app.grasp.shape_spread import Spread, spread
from rehab_app.hand.subject import geometry_from_json
from robot_iface.kinematics import forward
from sessions.errors import Refused
from sessions.metrics.hand_motion import FLEXION
from sessions.metrics.repetitions import cycles, main_movement
from sessions.records.fields import Float64, Int64
from sessions.records.names import DIGITS, LANDMARKS
from sessions.records.topics import HAND_POSE
from sessions.store import SessionReader

_INNER = {"thumb": ("mcp", "ip")}  # the two joints of a digit that are curved, where not PIP and DIP


@dataclass(frozen=True, slots=True)
class TakeShape:
    """The hand at the end of each closing, over one take or several of the same movement.

    Attributes:
        t_s: When, from the start of its take, shape (R,).
        shape: The hand in these R frames.
    """

    t_s: Float64
    shape: HandShape

    def spreads(self) -> dict[str, Spread]:
        """Mean and standard deviation over the repetitions, by measure, SI units."""
        shape = self.shape
        return {
            "aperture_rad": spread(shape.aperture_rad),
            "curvature_per_m": spread(shape.curvature_per_m),
            "radius_m": spread(shape.radius_m),
            "pip_distance_m": spread(shape.pip_distance_m),
            "abduction_rad": spread(shape.abduction_rad),
            "opposition_rad": spread(shape.opposition_rad),
        }


def shape_of_take(path: Path) -> TakeShape:
    """The shape of the hand in a take, at the end of each closing.

    A closing is a stroke of the hand's main movement towards flexion. In a take of one grasp that is held,
    as in the thesis, its end is the last frame. A take without a movement gives its last whole frame.

    Raises:
        Refused: There is no such take, or it never shows the whole hand.
    """
    if not path.is_file():
        raise Refused("take", repr(str(path)), "a take that exists", "check the path")
    with SessionReader(path) as reader:
        header = reader.header
        if header.kind != "take":
            raise Refused(f"session {path.name}", f"a {header.kind} session", "a take", "choose a take")
        rows = reader.columns(HAND_POSE, names=("joints_rad",))
    geometry = geometry_from_json(header.subject_hand)
    t_ns: Int64 = rows.t_ns
    joints_rad: Float64 = rows["joints_rad"]
    whole = np.flatnonzero(np.isfinite(joints_rad).all(axis=1)) if len(t_ns) else np.zeros(0, dtype=np.int64)
    if not whole.size:
        raise Refused(
            f"take {path.name}", "without a frame of the whole hand", "of a whole hand", "record it again"
        )
    t_s = 1e-9 * (t_ns - t_ns[0]).astype(np.float64)
    closed = closed_rows(t_s, joints_rad)
    chosen = closed if closed.size else whole[-1:]
    return TakeShape(t_s[chosen], hand_shape(forward(geometry, joints_rad[chosen]).landmarks_m, header.side))


def shape_of_takes(paths: Sequence[Path]) -> TakeShape:
    """The repetitions of several takes together.

    Raises:
        Refused: None is given, or one cannot be used.
    """
    if not paths:
        raise Refused("takes", "none", "one or more", "name a take")
    parts = [shape_of_take(path) for path in paths]
    return TakeShape(
        np.concatenate([part.t_s for part in parts]),
        HandShape(
            np.concatenate([part.shape.aperture_rad for part in parts]),
            np.concatenate([part.shape.curvature_per_m for part in parts]),
            np.concatenate([part.shape.pip_distance_m for part in parts]),
            np.concatenate([part.shape.abduction_rad for part in parts]),
            np.concatenate([part.shape.opposition_rad for part in parts]),
        ),
    )


def closed_rows(t_s: Float64, joints_rad: Float64) -> Int64:
    """Rows in which a closing of the hand ends, rising.

    Args:
        t_s: Times, shape (N,).
        joints_rad: Angles, shape (N, 21), NaN where lost.
    """
    movement = main_movement(joints_rad, FLEXION)
    known = np.flatnonzero(np.isfinite(movement))
    ends: list[int] = []
    for start_s, end_s in cycles(t_s, movement).strokes_s:
        first, last = (int(known[np.argmin(np.abs(t_s[known] - at_s))]) for at_s in (start_s, end_s))
        if movement[last] > movement[first] and np.isfinite(joints_rad[last]).all():
            ends.append(last)
    return np.unique(np.array(ends, dtype=np.int64))


def shape_json(found: TakeShape) -> dict[str, Any]:
    """Mean and standard deviation of every measure as JSON, SI units; null where there is none.

    Curvature stands at a digit's four landmarks, 0 at both ends; radii only at the two joints between.
    """
    spreads = found.spreads()
    radius = spreads["radius_m"]
    opposition = spreads["opposition_rad"]
    return {
        "repetitions": len(found.t_s),
        "t_s": found.t_s.tolist(),
        "aperture_rad": _entry(spreads["aperture_rad"], ()),
        "curvature_per_m": {
            digit: {
                LANDMARKS[4 * row + at].removeprefix(f"{digit}_"): _entry(
                    spreads["curvature_per_m"], (row, at)
                )
                for at in range(4)
            }
            for row, digit in enumerate(DIGITS)
        },
        "radius_m": {
            digit: {
                joint: _entry(radius, (row, column))
                for column, joint in enumerate(_INNER.get(digit, ("pip", "dip")))
            }
            for row, digit in enumerate(DIGITS)
        },
        "pip_distance_m": {
            pair: _entry(spreads["pip_distance_m"], (row,)) for row, pair in enumerate(NEIGHBOURS)
        },
        "abduction_rad": {
            pair: _entry(spreads["abduction_rad"], (row,)) for row, pair in enumerate(NEIGHBOURS)
        },
        "opposition_rad": {
            "in_plane": _entry(opposition, (0,)),
            "from_axis": _entry(opposition, (1,)),
        },
    }


def _entry(found: Spread, at: tuple[int, ...]) -> dict[str, float | int | None]:
    mean, sd = float(found.mean[at]), float(found.sd[at])
    return {
        "mean": mean if math.isfinite(mean) else None,
        "sd": sd if math.isfinite(sd) else None,
        "count": int(found.count[at]),
    }
