"""Whole exercises at a level: deep fists, tapping, single fingers, opposition, grasp, abduction, mixed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rehab_app.cameras.levels import Level
from rehab_app.cameras.scripted_motion import OPEN_S, ScriptedMotion, Sway, Tremor, posture
from robot_iface.kinematics import JOINT_MAX_RAD, JOINT_MIN_RAD
from robot_iface.types import FINGERS, JOINTS
from sessions.errors import Refused
from sessions.records.fields import Float64

EXERCISES = ("fist", "tapping", "single_finger", "opposition", "cylinder", "abduction")
"""What a mixed sequence is made of; each can be had alone."""

_ALSO = {"open_close": "fist", "index_pip": "single_finger", "pinch": "opposition", "spread": "abduction"}
"""What the movements of ``scripted_motion`` are called here."""

_SWAY_HZ = 0.45
_TREMOR_RAD = float(np.deg2rad(0.35))
_VARIETY = 0.07  # by how much people differ in how far a joint goes, as a share
_LOOSE_RAD = float(np.deg2rad(3.0))  # and how far each stop is from the last
_SHARES = (0.38, 0.16, 0.36, 0.10)  # of a leg's time: out, hold, back, rest


@dataclass(frozen=True, slots=True)
class Leg:
    """From the open hand to a posture and back.

    Attributes:
        target_rad: The posture, shape (21,).
        seconds: Time of the leg at speed 1.
    """

    target_rad: Float64
    seconds: float


def level_motion(exercise: str, level: Level, seconds: float, rng: np.random.Generator) -> ScriptedMotion:
    """An exercise as it is done at a level, the first 1.2 s open and still.

    Args:
        exercise: One of EXERCISES, or ``mixed`` for all of them in some order, or ``still``. The names of
            ``scripted_motion`` stand for the exercise that is most like them.
        level: How deep and fast.
        seconds: Time to fill; the last repetition may end later.
        rng: Draws order, variety and tremor.

    Raises:
        Refused: There is no such exercise.
    """
    known = (*EXERCISES, "mixed", "still", *_ALSO)
    if exercise not in known:
        raise Refused("exercise", repr(exercise), "one of " + ", ".join(known), "choose one of them")
    chosen = _ALSO.get(exercise, exercise)
    home = _varied(posture(), rng, np.ones(len(JOINTS)))
    shares = 1.0 + _VARIETY * rng.uniform(-1.0, 1.0, len(JOINTS))
    times, postures = [0.0, OPEN_S], [home, home]
    while times[-1] < seconds:
        names = list(rng.permutation(EXERCISES)) if chosen == "mixed" else [chosen]
        for leg in (leg for name in names for leg in _legs(str(name), rng)):
            target = _varied(home + level.amplitude * (leg.target_rad - posture()), rng, shares)
            marks = times[-1] + leg.seconds / level.speed * np.cumsum(_SHARES)
            times += [float(mark) for mark in marks]
            postures += [target, target, home, home]
    tremor = Tremor(_TREMOR_RAD, rng.uniform(5.0, 9.0, len(JOINTS)), rng.uniform(0.0, 6.28, len(JOINTS)))
    sway = Sway(level.sway_m, level.sway_rad, _SWAY_HZ)
    return ScriptedMotion(exercise, np.array(times), np.array(postures), sway, tremor)


def _varied(joints_rad: Float64, rng: np.random.Generator, shares: Float64) -> Float64:
    """The posture as this person does it this time, within anatomical limits."""
    loose = rng.normal(0.0, _LOOSE_RAD, len(JOINTS)) * np.minimum(np.abs(joints_rad) / 0.3, 1.0)
    return np.clip(joints_rad * shares + loose, JOINT_MIN_RAD, JOINT_MAX_RAD)


def _legs(exercise: str, rng: np.random.Generator) -> list[Leg]:
    """One go of an exercise at full depth."""
    if exercise == "fist":
        return [Leg(_fist(), 2.8)] * 2
    if exercise == "tapping":
        return [Leg(posture(**{f"{one}_mcp_flexion": 60.0, f"{one}_pip": 25.0}), 0.8) for one in FINGERS]
    if exercise == "single_finger":
        chosen = rng.choice(FINGERS, 2, replace=False)
        return [Leg(posture(**{f"{one}_mcp_flexion": 75.0, f"{one}_pip": 98.0}), 1.5) for one in chosen]
    if exercise == "opposition":
        return [Leg(_opposed(row), 1.3) for row in range(len(FINGERS))]
    if exercise == "cylinder":
        return [Leg(cylinder_grasp(), 2.5)] * 2
    return [Leg(_spread() if exercise == "abduction" else posture(), 1.8)] * 2


def _fist() -> Float64:
    """A deep fist, the thumb over the fingers."""
    mcp = dict(zip(FINGERS, (82.0, 86.0, 88.0, 90.0), strict=True))
    return posture(
        **{f"{one}_mcp_flexion": mcp[one] for one in FINGERS},
        **{f"{one}_pip": 98.0 for one in FINGERS},
        **{f"{one}_mcp_abduction": 0.0 for one in FINGERS},
        thumb_cmc_flexion=25.0,
        thumb_mcp_flexion=38.0,
        thumb_ip=45.0,
    )


def _opposed(row: int) -> Float64:
    """Thumb and one finger meet; the farther the finger, the farther the thumb goes."""
    one = FINGERS[row]
    return posture(
        **{f"{one}_mcp_flexion": 52.0, f"{one}_pip": 52.0},
        thumb_cmc_abduction=12.0 - 4.0 * row,
        thumb_cmc_flexion=18.0 + 7.0 * row,
        thumb_mcp_flexion=20.0 + 9.0 * row,
        thumb_ip=25.0 + 6.0 * row,
    )


def cylinder_grasp() -> Float64:
    """Fingers and thumb around a cylinder of some 5 cm, shape (21,)."""
    return posture(
        **{f"{one}_mcp_flexion": 58.0 for one in FINGERS},
        **{f"{one}_pip": 62.0 for one in FINGERS},
        **{f"{one}_mcp_abduction": 0.0 for one in FINGERS},
        thumb_cmc_abduction=18.0,
        thumb_cmc_flexion=22.0,
        thumb_mcp_flexion=26.0,
        thumb_ip=32.0,
    )


def _spread() -> Float64:
    """Fingers as far apart as they go."""
    return posture(
        thumb_cmc_abduction=-20.0,
        index_mcp_abduction=16.0,
        middle_mcp_abduction=3.0,
        ring_mcp_abduction=-12.0,
        little_mcp_abduction=-20.0,
    )
