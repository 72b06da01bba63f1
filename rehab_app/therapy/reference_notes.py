"""What became of a take on its way to a reference, in sentences for a therapist."""

from __future__ import annotations

import numpy as np

from rehab_app.recording.take import HandMotion
from robot_iface.types import Limits
from sessions.records import JOINTS
from sessions.records.fields import Float64, Int64

CLIP_NOTE_RAD = float(np.deg2rad(1.0))
"""From where on a clip to the limits is worth a sentence."""
GAP_NOTE_S = 0.5
"""From where on a bridged gap is worth one."""
MOVES_RAD = float(np.deg2rad(5.0))
"""Less than this of every joint is no exercise."""


def trim_notes(motion: HandMotion, span_s: tuple[float, float]) -> tuple[str, ...]:
    """What was left out of a still beginning and end."""
    head_s, tail_s = span_s[0] - float(motion.t_s[0]), float(motion.t_s[-1]) - span_s[1]
    ends = ((head_s, "start"), (tail_s, "end"))
    parts = [f"{length:.1f} s at its {end}" for length, end in ends if length > 0.05]
    return (f"The take was trimmed of {' and '.join(parts)}.",) if parts else ()


def gap_notes(motion: HandMotion, driven: Int64) -> tuple[str, ...]:
    """Driven joints that were never seen, or not for a while."""
    notes: list[str] = []
    for joint in driven:
        seen_s = motion.t_s[np.isfinite(motion.joints_rad[:, joint])]
        if not seen_s.size:
            notes.append(f"{JOINTS[joint]} was never seen: it is held at 0 deg.")
            continue
        gaps_s = np.diff(seen_s)
        if gaps_s.size and float(gaps_s.max()) > GAP_NOTE_S:
            worst = int(np.argmax(gaps_s))
            notes.append(
                f"{JOINTS[joint]} was not seen for {gaps_s[worst]:.1f} s from {seen_s[worst]:.1f} s on: "
                "the gap is bridged smoothly."
            )
    return tuple(notes)


def stillness_notes(names: tuple[str, ...], path_rad: Float64) -> tuple[str, ...]:
    """A path that is hardly a movement: a countdown was cut off, or the hand waited.

    Args:
        names: The J driven joints.
        path_rad: Angles of the path, shape (K, J).
    """
    travels = np.ptp(path_rad, axis=0)
    most = int(np.argmax(travels))
    if travels[most] >= MOVES_RAD:
        return ()
    return (
        f"The take hardly moves: {names[most]} travels furthest, {np.rad2deg(travels[most]):.0f} deg; "
        f"a start of the patient's own is seen from {np.rad2deg(MOVES_RAD):.0f} deg on.",
    )


def clip_notes(names: tuple[str, ...], wish_rad: Float64, limits: Limits) -> tuple[str, ...]:
    """By how much the limits cut each joint.

    Args:
        names: The J driven joints.
        wish_rad: Smooth angles before the limits, shape (K, J).
        limits: Bounds of those joints.
    """
    notes: list[str] = []
    for joint, name in enumerate(names):
        low, high = float(limits.q_min_rad[joint]), float(limits.q_max_rad[joint])
        over, under = float(wish_rad[:, joint].max()) - high, low - float(wish_rad[:, joint].min())
        for amount, bound, way in ((over, high, "upper"), (under, low, "lower")):
            if amount > CLIP_NOTE_RAD:
                notes.append(
                    f"Limits clipped {name} by {np.rad2deg(amount):.0f} deg at its {way} end "
                    f"({np.rad2deg(bound):.0f} deg)."
                )
    return tuple(notes)


def posture_notes(
    names: tuple[str, ...], asked_rad: Float64, low_rad: Float64, high_rad: Float64, take_s: Float64
) -> tuple[str, ...]:
    """Postures that a robot with a chain of its own cannot make, the worst of each joint.

    Args:
        names: Its J joints.
        asked_rad: What the movement would need of them, shape (K, J).
        low_rad: Lower ends of what they can do, shape (J,).
        high_rad: Upper ends, shape (J,).
        take_s: Time in the take of each row, shape (K,).
    """
    beyond = np.maximum(asked_rad - high_rad, low_rad - asked_rad)
    notes: list[str] = []
    for joint, name in enumerate(names):
        worst = int(np.argmax(beyond[:, joint]))
        if beyond[worst, joint] > CLIP_NOTE_RAD:
            asked = float(asked_rad[worst, joint])
            bound = high_rad[joint] if asked > high_rad[joint] else low_rad[joint]
            notes.append(
                f"The robot cannot make the posture at {take_s[worst]:.1f} s of the take: {name} would be at "
                f"{np.rad2deg(asked):.0f} deg, its end is {np.rad2deg(bound):.0f} deg."
            )
    return tuple(notes)
