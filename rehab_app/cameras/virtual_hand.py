"""A virtual camera before a hand that does a named exercise: what the demo and the tests record from."""

from __future__ import annotations

import numpy as np

from rehab_app.cameras.level_scene import level_scene
from rehab_app.cameras.levels import Level, level_of
from rehab_app.cameras.scene import hand_scene
from rehab_app.cameras.scripted_motion import OPEN_S, scripted_motion
from rehab_app.cameras.sensor import NoiseLevel
from rehab_app.cameras.virtual import VirtualCamera
from rehab_app.cameras.worn_markers import wear_markers
from rehab_app.geometry.view import PRIMARY, View
from rehab_app.hand.protocol import MarkerProtocol
from robot_iface.kinematics import average_hand
from sessions.records import Side

FACING: tuple[View, ...] = (
    PRIMARY,
    View(1, np.diag([-1.0, 1.0, -1.0]), np.array([0.0, 0.0, 1.5])),
)
"""Two cameras 1.5 m apart that look at each other; the hand is held between them."""


def virtual_camera(
    exercise: str,
    side: Side,
    seconds: float,
    protocol: MarkerProtocol,
    *,
    seed: int = 0,
    length_m: float = 0.185,
    period_s: float = 3.0,
    amplitude: float = 1.0,
    angle_deg: float = 40.0,
    realtime: bool = False,
    noise: NoiseLevel | None = None,
    level: str | Level | None = None,
) -> VirtualCamera:
    """A camera before which a hand repeats an exercise for about ``seconds``.

    Args:
        exercise: One of MOTIONS; at a level, one of ``exercise_mix.EXERCISES``, or ``mixed`` for all of them.
        side: Side of the hand.
        seconds: Time to fill with whole cycles after the still second; the hand then holds still.
        protocol: The markers that the hand wears.
        seed: Of noise, sway, background and how the markers were stuck on.
        length_m: Hand length.
        period_s: Time of one cycle, at most.
        amplitude: Share of the movement.
        angle_deg: Angle of ``index_pip``.
        realtime: Frames come at their time of capture.
        noise: What the sensor adds.
        level: How fast and deep the hand moves, and what goes wrong in the pictures: every seed is another
            person's hand, and the level says what ``period_s`` and ``amplitude`` say otherwise. None for a
            hand of average proportions in pictures with nothing but noise.

    Raises:
        Refused: A value is out of its bound, or there is no such exercise or level.
    """
    if level is not None:
        return virtual_cameras(
            exercise,
            side,
            seconds,
            protocol,
            level=level,
            seed=seed,
            length_m=length_m,
            realtime=realtime,
            noise=noise,
        )[0]
    rng = np.random.default_rng(seed)
    worn = wear_markers(average_hand(length_m, side), protocol, rng)
    cycles = min(max(1, int((seconds - OPEN_S) / period_s)), 1000)
    motion = scripted_motion(
        exercise, cycles=cycles, period_s=period_s, amplitude=amplitude, angle_deg=angle_deg
    )
    return VirtualCamera(hand_scene(worn, motion, rng), seed=seed, realtime=realtime, noise=noise)


def virtual_cameras(
    exercise: str,
    side: Side,
    seconds: float,
    protocol: MarkerProtocol,
    *,
    level: str | Level = "medium",
    views: tuple[View, ...] = (PRIMARY,),
    seed: int = 0,
    length_m: float | None = None,
    realtime: bool = False,
    noise: NoiseLevel | None = None,
) -> tuple[VirtualCamera, ...]:
    """Cameras before which one and the same hand exercises at a level, on one clock.

    Args:
        exercise: One of ``exercise_mix.EXERCISES``, or ``mixed`` for all of them.
        side: Side of the hand.
        seconds: Time to fill.
        protocol: The markers that the hand wears.
        level: How fast and deep it moves, and what goes wrong in the pictures.
        views: Where the cameras stand; ``FACING`` are two that face each other with the hand between them.
        seed: Of everything: same arguments and seed, same frames.
        length_m: Hand length; drawn if None.
        realtime: Frames come at their time of capture.
        noise: What the sensors add.

    Raises:
        Refused: There is no such exercise or level, or no human hand is as long.
    """
    row = level_of(level) if isinstance(level, str) else level
    rng = np.random.default_rng([seed, 11])
    scene = level_scene(row, exercise, seconds, protocol, side, rng, length_m=length_m)
    return tuple(
        VirtualCamera(scene, seed=seed, realtime=realtime, noise=noise, level=row, view=view)
        for view in views
    )
