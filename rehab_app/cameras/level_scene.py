"""The scene of a level: another person's hand, markers stuck on by a human, somewhere before the camera."""

from __future__ import annotations

import numpy as np

from rehab_app.cameras.exercise_mix import level_motion
from rehab_app.cameras.levels import Level
from rehab_app.cameras.scene import HandScene
from rehab_app.cameras.varied_hand import varied_hand
from rehab_app.cameras.worn_markers import wear_markers
from rehab_app.hand.protocol import MarkerProtocol
from sessions.records import Side

_DISTANCE_M = (0.62, 0.88)
_LENGTH_M = (0.165, 0.205)
_TILT_DEG = (15.0, 30.0)
_ROLL_DEG = 20.0
_PLACING_M = 0.0015


def level_scene(
    level: Level,
    exercise: str,
    seconds: float,
    protocol: MarkerProtocol,
    side: Side,
    rng: np.random.Generator,
    *,
    length_m: float | None = None,
    distance_m: float | None = None,
) -> HandScene:
    """A hand at a level; every draw of ``rng`` is another person, held up another way.

    Args:
        level: How deep, fast and far it moves.
        exercise: One of ``exercise_mix.EXERCISES``, or ``mixed``.
        seconds: Time that the movement fills.
        protocol: The markers that it wears.
        side: Side of the hand.
        rng: Draws hand, markers, place and movement.
        length_m: Hand length; drawn (0.165 to 0.205 m) if None.
        distance_m: From camera to wrist; drawn (0.62 to 0.88 m) if None.

    Raises:
        Refused: Unknown exercise, or no human hand is as long.
    """
    drawn_length, drawn_distance = float(rng.uniform(*_LENGTH_M)), float(rng.uniform(*_DISTANCE_M))
    geometry = varied_hand(drawn_length if length_m is None else length_m, side, rng)
    worn = wear_markers(geometry, protocol, rng, placing_std_m=_PLACING_M)
    tilt, roll = np.deg2rad(rng.uniform(*_TILT_DEG)), np.deg2rad(rng.uniform(-_ROLL_DEG, _ROLL_DEG))
    motion = level_motion(exercise, level, seconds, rng)
    away = drawn_distance if distance_m is None else distance_m
    where = np.array([0.0, 0.45 * geometry.length_m, away])
    return HandScene(worn, motion, rng.uniform(0.0, 2.0 * np.pi, (6, 3)), where, float(tilt), float(roll))
