"""From a person's hand to the DLR-HIT-Hand II: every fingertip to its like place, as far as the robot can.

A digit of both hands abducts at its base and then bends in one plane. There, MCP and PIP (DIP = PIP) are
chosen so that tip and pointing match: tip over the digit's length, angle of the last bone. The thumb is taken
in the same way, as seen from its own base: the robot's stands opposed to the fingers for good, 9 cm from
where a person's thumb tip is at rest, so that its place in the palm has no like on the robot.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rehab_app.hand.retarget_range import within
from robot_iface.kinematics import HandGeometry
from robot_iface.kinematics.dlr_hit import LINKS_M
from sessions.records import DIGITS, FINGERS, JOINTS
from sessions.records.fields import Float64

ROBOT_JOINTS: tuple[str, ...] = (
    *("thumb_cmc_abduction", "thumb_mcp_flexion", "thumb_ip"),
    *(f"{finger}_{joint}" for finger in FINGERS for joint in ("mcp_abduction", "mcp_flexion", "pip")),
)
"""The 15 joints of the robot, each by the name of the human joint in whose place it stands."""

_LENGTH_M = sum(LINKS_M)
_POINTING = 0.15  # what a radian of pointing counts beside a finger length of place
_BENDING_STEPS = 12
_HUMAN: tuple[list[int], ...] = (
    [JOINTS.index(f"thumb_{name}") for name in ("cmc_flexion", "cmc_abduction", "mcp_flexion", "ip")],
    *(
        [JOINTS.index(f"{finger}_{name}") for name in ("mcp_flexion", "mcp_abduction", "pip", "dip")]
        for finger in FINGERS
    ),
)


@dataclass(frozen=True, slots=True)
class Retargeted:
    """A person's movement on the robot.

    Attributes:
        joints_rad: Angles in the order of ROBOT_JOINTS, strictly inside the ranges, shape (K, 15).
        asked_rad: What the same postures would need without ranges, shape (K, 15).
        residual_m: Distance of each fingertip from its like place, at the robot's size, shape (K, 5).
    """

    joints_rad: Float64
    asked_rad: Float64
    residual_m: Float64


def retarget(geometry: HandGeometry, joints_rad: Float64, low_rad: Float64, high_rad: Float64) -> Retargeted:
    """Bring a movement to the robot.

    Args:
        geometry: The person's hand; a left one is shown by the robot's right hand as its mirror image.
        joints_rad: Angles in the order of JOINTS, shape (K, 21).
        low_rad: Lower ends of the robot's ranges (or narrower limits), shape (15,).
        high_rad: Upper ends, shape (15,).
    """
    joints = np.empty((len(joints_rad), len(ROBOT_JOINTS)))
    asked = np.empty_like(joints)
    residual = np.empty((len(joints_rad), len(DIGITS)))
    for digit, columns in enumerate(_HUMAN):
        mine = slice(3 * digit, 3 * digit + 3)
        bones_m = geometry.bones_m[digit]
        human = joints_rad[:, columns]
        found = _digit(bones_m / float(bones_m.sum()), human, low_rad[mine], high_rad[mine])
        joints[:, mine], asked[:, mine], residual[:, digit] = found
    return Retargeted(joints, asked, residual)


def whole_robot_hand(robot_rad: Float64) -> Float64:
    """The 21 angles (N, 21) in the order of JOINTS that a robot posture (N, 15) stands for: DIP = PIP."""
    joints = np.zeros((len(robot_rad), len(JOINTS)))
    for column, name in enumerate(ROBOT_JOINTS):
        joints[:, JOINTS.index(name)] = robot_rad[:, column]
        if name.endswith("_pip"):
            joints[:, JOINTS.index(name) + 1] = robot_rad[:, column]
    return joints


def _digit(bones: Float64, human: Float64, low: Float64, high: Float64) -> tuple[Float64, Float64, Float64]:
    """Bounded angles (K, 3), those asked for (K, 3) and the tip's distance (K,) of one digit.

    Args:
        bones: The person's bones as parts of the digit, shape (3,).
        human: Flexion and abduction of the first joint, flexion of the second and third, shape (K, 4).
        low: Lower ends of abduction, MCP and PIP, shape (3,).
        high: Upper ends, shape (3,).
    """
    turned = np.cumsum(human[:, [0, 2, 3]], axis=1)
    place = np.stack([(bones * np.cos(turned)).sum(axis=1), (bones * np.sin(turned)).sum(axis=1)], axis=1)
    start = np.stack([human[:, 0], 0.5 * (human[:, 2] + human[:, 3])], axis=1)
    free = _bent(place, turned[:, 2], start, fixed_pip=False)
    asked = np.column_stack([human[:, 1], free])
    abduction, pip = (within(asked[:, at], float(low[at]), float(high[at])) for at in (0, 2))
    mcp = _bent(place, turned[:, 2], np.stack([free[:, 0], pip], axis=1), fixed_pip=True)[:, 0]
    joints = np.stack([abduction, within(mcp, float(low[1]), float(high[1])), pip], axis=1)
    reached = _in_space(_tip(joints[:, 1:]), joints[:, 0])
    off = _LENGTH_M * np.linalg.norm(reached - _in_space(place, human[:, 1]), axis=1)
    return joints, asked, off


def _bent(place: Float64, pointing: Float64, start: Float64, *, fixed_pip: bool) -> Float64:
    """MCP and PIP (K, 2) whose tip and pointing come nearest: Gauss-Newton from a start.

    Args:
        place: Tip in the finger's plane over its length (distal, palmar), shape (K, 2).
        pointing: Angle of the last bone, shape (K,).
        start: MCP and PIP to begin from, shape (K, 2).
        fixed_pip: Only MCP may move.
    """
    q = start.copy()
    free = np.array([1.0, 0.0 if fixed_pip else 1.0])
    for _ in range(_BENDING_STEPS):
        slopes = _tip_slopes(q) * free
        slopes = np.concatenate(
            [slopes, np.broadcast_to(_POINTING * free * [1.0, 2.0], (len(q), 1, 2))], axis=1
        )
        off = np.column_stack([place - _tip(q), _POINTING * (pointing - q[:, 0] - 2.0 * q[:, 1])])
        normal = np.swapaxes(slopes, 1, 2) @ slopes + np.diag(1.0 - free)
        step = np.linalg.solve(normal, np.swapaxes(slopes, 1, 2) @ off[..., None])[..., 0]
        q = q + np.clip(step, -0.5, 0.5)
    return q


def _tip(q: Float64) -> Float64:
    """Tip of a robot finger in its plane over its length, shape (K, 2), from MCP and PIP (K, 2)."""
    angles = q[:, :1] + q[:, 1:] * np.array([0.0, 1.0, 2.0])
    parts = np.array(LINKS_M) / _LENGTH_M
    return np.stack([(parts * np.cos(angles)).sum(axis=1), (parts * np.sin(angles)).sum(axis=1)], axis=1)


def _tip_slopes(q: Float64) -> Float64:
    """Derivative of the tip by MCP and PIP, shape (K, 2, 2)."""
    often = np.array([0.0, 1.0, 2.0])
    angles = q[:, :1] + q[:, 1:] * often
    parts = np.array(LINKS_M) / _LENGTH_M
    across, along = -parts * np.sin(angles), parts * np.cos(angles)
    return np.stack(
        [
            np.stack([across.sum(axis=1), across @ often], axis=1),
            np.stack([along.sum(axis=1), along @ often], axis=1),
        ],
        axis=1,
    )


def _in_space(place: Float64, abduction: Float64) -> Float64:
    """Points (distal, palmar) of a finger's plane as (distal, radial, palmar), shape (K, 3)."""
    return np.stack([place[:, 0] * np.cos(abduction), place[:, 0] * np.sin(abduction), place[:, 1]], axis=1)
