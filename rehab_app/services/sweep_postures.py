"""Where a guided sweep leads the fingers: the four postures that show how MCP and PIP share their range."""

from __future__ import annotations

import numpy as np

from robot_iface.types import Capabilities, Float64, Limits, Side, Sweep

RANGE = "range of motion sweep"
FIT = "fit check"
TONE = "tone at three speeds"
EXERCISES = {"range": RANGE, "fit": FIT, "tone": TONE}
"""What a guided assessment is called in files, by its kind."""
TONE_SPEEDS_RAD_S = tuple(float(np.deg2rad(speed)) for speed in (10.0, 45.0, 90.0))
TONE_REPEATS = 3
_FOLDED, _OPEN = 0.62, 0.06  # shares of today's widest range between which the fingers are stretched
_THUMB = 0.35

POSTURES: dict[str, tuple[float, float, float, float]] = {
    # share of today's widest range: MCP joints, PIP joints, thumb flexion, thumb abduction
    "open": (0.0, 0.0, 0.0, 1.0),
    "tabletop": (1.0, 0.0, 1.0, 0.5),
    "hook": (0.0, 1.0, 0.0, 0.0),
    "fist": (0.88, 0.88, 0.0, 0.5),
}
"""The thumb flexes while the fingers stand away from the palm, never under a fist, whose nails stay 5 mm from
the palm (hazard 8)."""


def postures_of(kind: str, joint_names: tuple[str, ...], limits: Limits) -> tuple[tuple[str, ...], Float64]:
    """Names and goals (P, J) of an assessment; none of a fit check, which moves around where the hand is.

    Args:
        kind: "range" or "fit".
        joint_names: The J driven joints.
        limits: The widest that the hand may be led to.
    """
    if kind == "fit":
        return (), np.zeros((0, len(joint_names)))
    shares = np.array(
        [[_share(name, posture) for name in joint_names] for posture in POSTURES.values()], dtype=np.float64
    )
    goals = limits.q_min_rad + shares * (limits.q_max_rad - limits.q_min_rad)
    return tuple(POSTURES), np.clip(goals, limits.q_min_rad, limits.q_max_rad)


def sweep_of(kind: str, device: Capabilities, side: Side, limits: Limits) -> Sweep:
    """The guided run of a kind: "range", "fit" or "tone".

    Args:
        kind: Which.
        device: The device; its joints are led.
        side: Side of the hand.
        limits: The widest that the hand may be led to.
    """
    if kind == "tone":
        return _tone(device.joint_names, side, limits)
    names, goals = postures_of(kind, device.joint_names, limits)
    return Sweep("fit" if kind == "fit" else "range", device.joint_names, side, names, goals)


def _tone(joint_names: tuple[str, ...], side: Side, limits: Limits) -> Sweep:
    """Nine stretches of all fingers, slow ones first; the thumb stays where it is out of the way."""
    fingers = np.array([_stretched(name) for name in joint_names])
    span = limits.q_max_rad - limits.q_min_rad
    start = limits.q_min_rad + np.where(fingers, _FOLDED, _THUMB) * span
    goal = np.where(fingers, limits.q_min_rad + _OPEN * span, start)
    speeds = tuple(speed for speed in TONE_SPEEDS_RAD_S for _ in range(TONE_REPEATS))
    return Sweep(
        "tone",
        joint_names,
        side,
        ("stretch",) * len(speeds),
        np.tile(goal, (len(speeds), 1)),
        stretch_rad_s=speeds,
        start_rad=tuple(start.tolist()),
    )


def _stretched(joint: str) -> bool:
    return not joint.startswith("thumb") and joint.endswith(("_mcp_flexion", "_pip"))


def _share(joint: str, posture: tuple[float, float, float, float]) -> float:
    mcp, pip, flexion, abduction = posture
    if joint.startswith("thumb"):
        return abduction if joint.endswith("_abduction") else flexion
    if joint.endswith("_abduction"):
        return 0.5
    return mcp if "_mcp_" in joint else pip
