"""DLR-HIT-Hand II: its five equal fingers as modified Denavit-Hartenberg chains, forward and inverse.

Tables 5.2 and 5.3 of the thesis hold only in Craig's modified form, T = Rx(alpha) Tx(a) Rz(theta) Tz(d): in
the classical form the straight finger is not 105 mm long. The palm frame is that of people: x palmar, y
radial, z distal, origin at the wrist (CMC). The distal joint follows the middle one, one to one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robot_iface.errors import Refused
from robot_iface.types import Float64

LINKS_M = (0.055, 0.025, 0.025)
"""Proximal, medial, distal link of every finger (Table 5.2), m."""
DH_ROWS: Float64 = np.array(
    [
        # alpha rad, a m, theta offset rad, d m
        [0.0, 0.0, 0.0, 0.0],
        [-np.pi / 2, 0.0, 0.0, 0.0],
        [0.0, LINKS_M[0], 0.0, 0.0],
        [0.0, LINKS_M[1], -np.pi / 2, 0.0],
        [-np.pi / 2, 0.0, np.pi, LINKS_M[2]],
    ]
)
"""Table 5.3, one row a frame: abduction, MCP, PIP, DIP and the fingertip."""
FINGER_MIN_RAD: Float64 = np.deg2rad([-15.0, 0.0, 0.0])
FINGER_MAX_RAD: Float64 = np.deg2rad([15.0, 80.0, 80.0])
"""Range of abduction, MCP and PIP of every finger, shape (3,), rad."""
THUMB_OPPOSITION_RAD = float(np.deg2rad(35.51))
THUMB_INCLINATION_RAD = float(np.deg2rad(44.13))
"""Where the thumb's base stands, seen from the wrist: angle in the x-y plane, and from the z axis."""

# The hand's public description: bases in the palm frame, scaled so that they lie at Table 5.2's distances;
# the thumb keeps its distance and takes the thesis's direction.
_BASES_M = np.array(
    [[-0.0025, 0.0368, 0.1087], [-0.0037, 0.010, 0.119], [-0.0025, -0.0168, 0.114], [0.001, -0.0434, 0.095]]
)
_BASE_DISTANCE_M = np.array([0.117, 0.1183, 0.117, 0.105])
_THUMB_BASE_M = np.array([0.0626, 0.0445, 0.080])
# Roll, pitch and yaw of the thumb's module in the public description, rad.
_THUMB_RPY_RAD = (0.41136, -1.08366, 0.225804)
_FINGER_AXES = np.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]])
_REACH_M = 1e-9


@dataclass(frozen=True, slots=True)
class DlrHitHand:
    """Where the five fingers stand in the palm frame; their links are all alike.

    Attributes:
        bases_m: First joint of each digit (thumb, index, middle, ring, little), shape (5, 3).
        base_rotation: Columns are the distal, flexion and dorsal axes of each digit's base, shape (5, 3, 3).
        lateral_m: y of the four long fingers' bases as the thesis's chapter 5 is computed with, shape (4,).
        distance_m: Wrist to base of the four long fingers (Table 5.2, a_01 to a_04), shape (4,).
    """

    bases_m: Float64
    base_rotation: Float64
    lateral_m: Float64
    distance_m: Float64


def dlr_hit_hand() -> DlrHitHand:
    """The hand of the thesis."""
    long: Float64 = _BASES_M * (_BASE_DISTANCE_M / np.linalg.norm(_BASES_M, axis=1))[:, None]
    up, along = np.cos(THUMB_INCLINATION_RAD), np.sin(THUMB_INCLINATION_RAD)
    towards = [along * np.cos(THUMB_OPPOSITION_RAD), along * np.sin(THUMB_OPPOSITION_RAD), up]
    thumb: Float64 = float(np.linalg.norm(_THUMB_BASE_M)) * np.array(towards)
    rotation = np.broadcast_to(_FINGER_AXES, (5, 3, 3)).copy()
    # the description's module abducts about its palmar axis and flexes about minus its second
    rotation[0] = _roll_pitch_yaw(*_THUMB_RPY_RAD) * np.array([1.0, -1.0, -1.0])
    return DlrHitHand(np.vstack([thumb, long]), rotation, _BASES_M[:, 1].copy(), _BASE_DISTANCE_M.copy())


def aperture_rad(hand: DlrHitHand) -> float:
    """Angle at the wrist between the thumb's base and the index finger's, rad."""
    thumb, index = hand.bases_m[0], hand.bases_m[1]
    return float(np.arccos(thumb @ index / (np.linalg.norm(thumb) * np.linalg.norm(index))))


def finger_frames(finger_rad: Float64) -> Float64:
    """Frames of one finger in its base, by the rows of ``DH_ROWS``.

    Args:
        finger_rad: Abduction, MCP and PIP; the DIP joint follows the PIP joint. Shape (..., 3).

    Returns:
        Transforms of abduction, MCP, PIP, DIP and fingertip, shape (..., 5, 4, 4).
    """
    q = np.asarray(finger_rad, dtype=np.float64)
    moved = np.stack([q[..., 0], q[..., 1], q[..., 2], q[..., 2], np.zeros_like(q[..., 0])], axis=-1)
    frames = np.empty((*q.shape[:-1], 5, 4, 4))
    current = np.broadcast_to(np.eye(4), (*q.shape[:-1], 4, 4))
    for row, (alpha, a, offset, d) in enumerate(DH_ROWS):
        current = current @ _modified(float(alpha), float(a), moved[..., row] + float(offset), float(d))
        frames[..., row, :, :] = current
    return frames


def finger_points(finger_rad: Float64) -> Float64:
    """MCP, PIP, DIP joint and fingertip in the finger's base, shape (..., 4, 3), m."""
    return finger_frames(finger_rad)[..., 1:, :3, 3]


def hand_points(hand: DlrHitHand, joints_rad: Float64) -> Float64:
    """Joints and fingertip of every digit in the palm frame.

    Args:
        hand: The hand.
        joints_rad: Abduction, MCP and PIP of the five digits, shape (..., 5, 3).

    Returns:
        First joint, PIP, DIP and tip of each digit, shape (..., 5, 4, 3), m.
    """
    local = finger_points(joints_rad)
    return hand.bases_m[:, None] + np.einsum("dij,...dkj->...dki", hand.base_rotation, local)


def finger_inverse(tip_m: Float64) -> Float64:
    """Closed-form inverse of one finger.

    The squared distance of the fingertip from its base is a quadratic of cos(PIP) when DIP = PIP.

    Args:
        tip_m: Fingertip in the finger's base frame, shape (..., 3).

    Returns:
        Abduction, MCP and PIP, shape (..., 3).

    Raises:
        Refused: A point is not finite, out of reach, or needs a joint beyond its range.
    """
    tip = np.asarray(tip_m, dtype=np.float64)
    if not bool(np.isfinite(tip).all()):
        raise Refused("fingertip", "not finite", "a point in metres", "give finite coordinates")
    # a finger that closes past its own base lies behind it: the same plane, the other way round
    abduction = np.arctan2(tip[..., 1], tip[..., 0])
    behind = np.abs(abduction) > np.pi / 2
    abduction = np.where(behind, np.arctan2(-tip[..., 1], -tip[..., 0]), abduction)
    forth = np.where(behind, -1.0, 1.0) * np.hypot(tip[..., 0], tip[..., 1])
    pip = np.arccos(_cos_pip(np.hypot(forth, tip[..., 2])))
    first, second, third = LINKS_M
    along = first + second * np.cos(pip) + third * np.cos(2 * pip)
    across = second * np.sin(pip) + third * np.sin(2 * pip)
    mcp = np.arctan2(-tip[..., 2], forth) - np.arctan2(across, along)
    mcp = np.mod(mcp + np.pi, 2 * np.pi) - np.pi
    joints = np.stack([abduction, mcp, pip], axis=-1)
    _check_range(joints)
    return joints


def _cos_pip(distance_m: Float64) -> Float64:
    """cos(PIP) from the distance of the tip to its base: the root on the side of the straight finger."""
    first, second, third = LINKS_M
    longest = first + second + third
    if bool((distance_m > longest + _REACH_M).any()):
        raise Refused(
            "fingertip distance",
            f"{float(np.max(distance_m)):.4g} m",
            f"at most {longest:g} m from its base",
            "bring the point nearer",
        )
    square = 4 * first * third
    linear = 2 * second * (first + third)
    constant = first**2 + second**2 + third**2 - 2 * first * third - np.minimum(distance_m, longest) ** 2
    inner = linear**2 - 4 * square * constant
    if bool((inner < 0).any()):
        raise Refused(
            "fingertip distance",
            f"{float(np.min(distance_m)):.4g} m",
            "farther from its base",
            "move the point out",
        )
    cosine: Float64 = np.clip((-linear + np.sqrt(inner)) / (2 * square), -1.0, 1.0)
    return cosine


def _check_range(joints_rad: Float64) -> None:
    for index, name in enumerate(("abduction", "MCP", "PIP")):
        low, high = float(FINGER_MIN_RAD[index]), float(FINGER_MAX_RAD[index])
        angles = joints_rad[..., index]
        outside = np.maximum(low - angles, angles - high)
        if bool((outside > 1e-7).any()):
            worst = float(np.ravel(angles)[int(np.argmax(outside))])
            raise Refused(
                f"{name} angle",
                f"{worst:.4g} rad",
                f"{low:.4g} to {high:.4g} rad",
                "choose another fingertip",
            )


def _modified(alpha_rad: float, a_m: float, theta_rad: Float64, d_m: float) -> Float64:
    """Rx(alpha) Tx(a) Rz(theta) Tz(d), shape (..., 4, 4)."""
    ca, sa = np.cos(alpha_rad), np.sin(alpha_rad)
    ct, st = np.cos(theta_rad), np.sin(theta_rad)
    zero, one = np.zeros_like(ct), np.ones_like(ct)
    rows = [ct, -st, zero, a_m * one, ca * st, ca * ct, -sa * one, -sa * d_m * one]
    rows += [sa * st, sa * ct, ca * one, ca * d_m * one, zero, zero, zero, one]
    return np.stack(rows, axis=-1).reshape(*ct.shape, 4, 4)


def _roll_pitch_yaw(roll_rad: float, pitch_rad: float, yaw_rad: float) -> Float64:
    """Rz(yaw) Ry(pitch) Rx(roll), shape (3, 3)."""
    cr, sr = np.cos(roll_rad), np.sin(roll_rad)
    cp, sp = np.cos(pitch_rad), np.sin(pitch_rad)
    cy, sy = np.cos(yaw_rad), np.sin(yaw_rad)
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )
