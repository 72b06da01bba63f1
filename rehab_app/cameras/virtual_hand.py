"""A virtual camera before a hand that does a named exercise: what the demo and the tests record from."""

from __future__ import annotations

import numpy as np

from rehab_app.cameras.scene import hand_scene
from rehab_app.cameras.scripted_motion import OPEN_S, scripted_motion
from rehab_app.cameras.sensor import NoiseLevel
from rehab_app.cameras.virtual import VirtualCamera
from rehab_app.cameras.worn_markers import wear_markers
from rehab_app.hand.protocol import MarkerProtocol
from robot_iface.kinematics import average_hand
from sessions.records import Side


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
) -> VirtualCamera:
    """A camera before which a hand repeats an exercise for about ``seconds``.

    Args:
        exercise: One of MOTIONS.
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

    Raises:
        Refused: A value is out of its bound.
    """
    rng = np.random.default_rng(seed)
    worn = wear_markers(average_hand(length_m, side), protocol, rng)
    cycles = min(max(1, int((seconds - OPEN_S) / period_s)), 1000)
    motion = scripted_motion(
        exercise, cycles=cycles, period_s=period_s, amplitude=amplitude, angle_deg=angle_deg
    )
    return VirtualCamera(hand_scene(worn, motion, rng), seed=seed, realtime=realtime, noise=noise)
