"""Difficulty levels: how fast and deep a hand moves before a virtual camera, and how badly it is seen."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sessions.errors import Refused
from sessions.records.fields import Float64

CALM_S = 1.0
"""How long every level begins without a missed marker or a lost frame."""
_BURST = (3, 9)  # frames lost in a burst


@dataclass(frozen=True, slots=True)
class Level:
    """One row of the table of difficulties.

    Attributes:
        name: Name of the level.
        amplitude: Share of the whole movement; 1 closes the hand to a deep fist.
        speed: Speed of the movement; 1 closes and opens the hand in 2.8 s.
        miss_share: Share of the visible markers that the detector misses.
        centre_std_px: Standard deviation of a centre's u and of its v.
        clutter: Mean number of false blobs in a frame; half of them anywhere, half near the hand.
        persistent: Number of false blobs that stay where they are.
        dropped_share: Share of the frames that are lost singly.
        burst_share: Share of the frames at which a loss of several frames begins.
        sway_m: Peak wandering of the hand along each axis, m.
        sway_rad: Peak turning of the hand about each axis, rad.
        hole_share: Share of the detections without depth.
        outlier_share: Share of the detections whose depth is wrong by centimetres.
        light_share: By how much the light in a picture wavers, as a share.
    """

    name: str
    amplitude: float
    speed: float
    miss_share: float
    centre_std_px: float
    clutter: float
    persistent: int
    dropped_share: float
    burst_share: float
    sway_m: float
    sway_rad: float
    hole_share: float
    outlier_share: float
    light_share: float = 0.0


LEVELS: dict[str, Level] = {
    row.name: row
    for row in (
        Level("easy", 0.3, 0.6, 0.01, 0.4, 0.3, 0, 0.0, 0.0, 0.015, np.deg2rad(10.0), 0.01, 0.0, 0.05),
        Level("medium", 0.65, 1.0, 0.03, 0.6, 1.5, 1, 0.005, 0.0, 0.04, np.deg2rad(20.0), 0.03, 0.01, 0.12),
        Level("hard", 1.0, 1.5, 0.06, 0.9, 3.5, 3, 0.02, 0.0, 0.07, np.deg2rad(32.0), 0.06, 0.03, 0.22),
        Level("extreme", 1.0, 2.0, 0.12, 1.3, 9.0, 5, 0.03, 0.004, 0.11, np.deg2rad(45.0), 0.10, 0.06, 0.30),
    )
}
"""The levels by name, easiest first."""


def level_of(name: str) -> Level:
    """A level by its name.

    Raises:
        Refused: There is no such level.
    """
    if name not in LEVELS:
        raise Refused("level", repr(name), "one of " + ", ".join(LEVELS), "choose one of them")
    return LEVELS[name]


def dropped_frames(level: Level, t_s: Float64, rng: np.random.Generator) -> NDArray[np.bool_]:
    """Frames that never come, singly and in bursts, of captures at times (F,), shape (F,)."""
    lost = rng.random(len(t_s)) < level.dropped_share
    for start in np.flatnonzero(rng.random(len(t_s)) < level.burst_share):
        lost[start : start + int(rng.integers(*_BURST))] = True
    return lost & (t_s >= CALM_S)
