"""Where a guided sweep leads the fingers: the four postures that show how MCP and PIP share their range."""

from __future__ import annotations

import numpy as np

from robot_iface.types import Float64, Limits

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


def _share(joint: str, posture: tuple[float, float, float, float]) -> float:
    mcp, pip, flexion, abduction = posture
    if joint.startswith("thumb"):
        return abduction if joint.endswith("_abduction") else flexion
    if joint.endswith("_abduction"):
        return 0.5
    return mcp if "_mcp_" in joint else pip
