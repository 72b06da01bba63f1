"""The way to the posture: every fingertip on a logarithmic spiral about its knuckle (eqs. 5.7 and 5.8).

r(theta) = r_0 exp(b (theta - theta_0)) with b = ln(r_f/r_0) / (theta_f - theta_0). Along it the inverse
kinematics with the hand's own coupling gives the joints. From the straight finger the way is singular: the
middle joint would begin at full speed and the knuckle would dip below its range, so it starts at 22 degrees
of the middle joint or more.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from rehab_app.errors import Refused
from rehab_app.grasp.hand import GraspHand
from rehab_app.grasp.posture import Posture
from sessions.records import FINGERS, JOINTS
from sessions.records.fields import Float64

LEAST_PIP_RAD = math.radians(22.0)
"""Flexion of the middle joints at which the way may start."""
SAMPLES = 101
_STARTS_DEG = range(24, 62, 2)
_NEWTON = 60
_SLACK_RAD = 1e-9


@dataclass(frozen=True, slots=True)
class GraspPath:
    """A way to a posture; the path coordinate runs from 0 to 1.

    Attributes:
        s: Path coordinate, strictly increasing, shape (N,).
        joints_rad: Angles in the order of JOINTS, shape (N, 21).
        tips_m: Tips of index, middle, ring and little finger from their knuckles: distal, palmar; (N, 4, 2).
        pitch: b of each finger's spiral, shape (4,).
        start_pip_rad: Flexion of the middle joints at the start.
        warnings: What does not run one way.
    """

    s: Float64
    joints_rad: Float64
    tips_m: Float64
    pitch: Float64
    start_pip_rad: float
    warnings: tuple[str, ...]


def spiral_path(posture: Posture, start_pip_rad: float | None = None, samples: int = SAMPLES) -> GraspPath:
    """The way from an open hand to a posture, thumb included (its joints go evenly).

    Args:
        posture: Where to end.
        start_pip_rad: Flexion of the middle joints at the start (a finger that ends straighter starts as it
            ends); the knuckles start straight. Unless given, the least from 22 degrees on from which every
            joint runs one way.
        samples: Points on the way, at least 2.

    Raises:
        Refused: The start is straighter than 22 degrees or too bent, or the way leaves a joint's range.
    """
    hand = posture.hand
    if start_pip_rad is None:
        way = _way(posture, LEAST_PIP_RAD, samples)
        for degrees in _STARTS_DEG:
            if not way.warnings:
                break
            bent = _way(posture, math.radians(degrees), samples)
            way = way if bent.warnings else bent
    elif LEAST_PIP_RAD - _SLACK_RAD <= start_pip_rad <= hand.pip_max_rad:
        way = _way(posture, start_pip_rad, samples)
    else:
        raise Refused(
            "start of the path",
            f"{start_pip_rad:.4g} rad at the middle joints",
            f"{LEAST_PIP_RAD:.4g} to {hand.pip_max_rad:.4g} rad",
            "start from a slightly bent hand",
        )
    _check(hand, way.joints_rad)
    return way


def _way(posture: Posture, start_pip_rad: float, samples: int) -> GraspPath:
    hand = posture.hand
    last = np.array(
        [[posture.angles_rad[f"{finger}_{joint}"] for joint in ("mcp_flexion", "pip")] for finger in FINGERS]
    )
    first = np.stack([np.zeros(4), np.minimum(start_pip_rad, last[:, 1])], axis=1)
    s = np.linspace(0.0, 1.0, samples)
    tips, pitch = _spirals(hand, first, last, s)
    mcp, pip = inverse(hand, tips)
    mcp[0], pip[0], mcp[-1], pip[-1] = first[:, 0], first[:, 1], last[:, 0], last[:, 1]
    return GraspPath(s, _named(posture, s, mcp, pip), tips, pitch, float(first[:, 1].max()), _turns(mcp, pip))


def tip_m(hand: GraspHand, mcp_rad: Float64, pip_rad: Float64) -> Float64:
    """Fingertips from their knuckles, distal and palmar, shape (..., 4, 2), from angles of shape (..., 4)."""
    angles = np.stack([mcp_rad, mcp_rad + pip_rad, mcp_rad + (1 + hand.dip_per_pip) * pip_rad], axis=-1)
    return np.stack(
        [(hand.links_m * np.cos(angles)).sum(axis=-1), (hand.links_m * np.sin(angles)).sum(axis=-1)], axis=-1
    )


def inverse(hand: GraspHand, tips_m: Float64) -> tuple[Float64, Float64]:
    """MCP and PIP flexion of fingertips, with the hand's coupling of the distal joint.

    The distance of the tip falls with PIP; it is solved for by Newton's method inside a shrinking bracket.

    Args:
        hand: The hand.
        tips_m: Tips from their knuckles, distal and palmar, shape (..., 4, 2).

    Returns:
        MCP and PIP, shape (..., 4), rad.

    Raises:
        Refused: A point is not finite or out of reach.
    """
    distance = np.linalg.norm(tips_m, axis=-1)
    zero = np.zeros_like(distance)
    least = np.linalg.norm(tip_m(hand, zero, zero + hand.pip_max_rad), axis=-1)
    most = np.broadcast_to(hand.links_m.sum(axis=1), distance.shape)
    outside = ~((distance >= least - 1e-9) & (distance <= most + 1e-9))
    if bool(outside.any()):
        at = int(np.argmax(outside.ravel()))
        raise Refused(
            "fingertip distance from its knuckle",
            f"{float(distance.ravel()[at]):.4g} m",
            f"{float(least.ravel()[at]):.4g} to {float(most.ravel()[at]):.4g} m",
            "choose a nearer point",
        )
    low, high = zero.copy(), zero + hand.pip_max_rad
    pip = (low + high) / 2
    for _ in range(_NEWTON):
        tip = tip_m(hand, zero, pip)
        over = (tip**2).sum(axis=-1) - distance**2
        slope = 2 * (tip * _tip_slope(hand, pip)).sum(axis=-1)
        low, high = np.where(over > 0, pip, low), np.where(over > 0, high, pip)
        wanted = pip - over / np.where(slope < 0, slope, -1e-9)
        better = np.where((wanted > low) & (wanted < high), wanted, (low + high) / 2)
        if float(np.abs(better - pip).max()) < 1e-15:
            break
        pip = better
    tip = tip_m(hand, zero, pip)
    mcp = np.arctan2(tips_m[..., 1], tips_m[..., 0]) - np.arctan2(tip[..., 1], tip[..., 0])
    return np.mod(mcp + np.pi / 2, 2 * np.pi) - np.pi / 2, pip


def _tip_slope(hand: GraspHand, pip: Float64) -> Float64:
    """Derivative of the tip by PIP, MCP straight, shape (..., 4, 2)."""
    more = 1 + hand.dip_per_pip
    medial, distal = hand.links_m[:, 1], hand.links_m[:, 2]
    return np.stack(
        [
            -medial * np.sin(pip) - more * distal * np.sin(more * pip),
            medial * np.cos(pip) + more * distal * np.cos(more * pip),
        ],
        axis=-1,
    )


def _spirals(hand: GraspHand, first: Float64, last: Float64, s: Float64) -> tuple[Float64, Float64]:
    """Tips on the way, shape (N, 4, 2), and each spiral's b, shape (4,)."""
    start, end = tip_m(hand, first[:, 0], first[:, 1]), tip_m(hand, last[:, 0], last[:, 1])
    r0, r1 = np.linalg.norm(start, axis=1), np.linalg.norm(end, axis=1)
    theta0, theta1 = np.arctan2(start[:, 1], start[:, 0]), np.arctan2(end[:, 1], end[:, 0])
    theta1 = np.where(theta1 < theta0 - 1e-12, theta1 + 2 * np.pi, theta1)
    swept = theta1 - theta0
    pitch = np.log(r1 / r0) / np.where(swept > 1e-9, swept, np.inf)
    theta = theta0 + s[:, None] * swept
    radius = r0 * np.exp(pitch * (theta - theta0))
    return radius[..., None] * np.stack([np.cos(theta), np.sin(theta)], axis=-1), pitch


def _check(hand: GraspHand, joints_rad: Float64) -> None:
    for name, low, high in (
        ("mcp_flexion", hand.mcp_min_rad, hand.mcp_max_rad),
        ("pip", 0.0, hand.pip_max_rad),
    ):
        for finger in FINGERS:
            angles = joints_rad[:, JOINTS.index(f"{finger}_{name}")]
            outside = np.maximum(low - angles, angles - high)
            if float(outside.max()) > _SLACK_RAD:
                raise Refused(
                    f"{finger}_{name} on the path",
                    f"{float(angles[int(np.argmax(outside))]):.4g} rad",
                    f"{low:.4g} to {high:.4g} rad",
                    "start from a more bent hand",
                )


def _turns(mcp: Float64, pip: Float64) -> tuple[str, ...]:
    said: list[str] = []
    for name, angles in (("knuckle", mcp), ("middle joint", pip)):
        back = np.diff(angles, axis=0).min(axis=0) < -_SLACK_RAD
        said += [
            f"the {FINGERS[index]} finger's {name} does not run one way" for index in np.flatnonzero(back)
        ]
    return tuple(said)


def _named(posture: Posture, s: Float64, mcp: Float64, pip: Float64) -> Float64:
    joints = np.zeros((len(s), len(JOINTS)))
    for name, angle in posture.angles_rad.items():
        if name.startswith("thumb"):
            joints[:, JOINTS.index(name)] = s * angle
    for index, finger in enumerate(FINGERS):
        joints[:, JOINTS.index(f"{finger}_mcp_flexion")] = mcp[:, index]
        joints[:, JOINTS.index(f"{finger}_pip")] = pip[:, index]
        joints[:, JOINTS.index(f"{finger}_dip")] = posture.hand.dip_per_pip * pip[:, index]
    return joints
