"""Driven joints as finger chains, lean enough to be evaluated once a tick.

Every digit is the chain of ``robot_iface.kinematics.forward``: flexion and abduction at the first joint,
flexion and (thumb only) abduction at the second, flexion at the third. The DLR-HIT-Hand's finger is the same
chain with its own links. Everything is stated in the frame of the digit's base: a stiffness that is alike in
all directions does not ask how the base is turned, nor which side the hand is.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from robot_iface.compiled import compiled
from robot_iface.errors import Refused
from robot_iface.kinematics import DIP_PER_PIP, HandGeometry
from robot_iface.kinematics.dlr_hit import LINKS_M
from robot_iface.types import DIGITS, Float64, Int64

_SLOT_OF = {
    "thumb_cmc_flexion": 0,
    "thumb_cmc_abduction": 1,
    "thumb_mcp_flexion": 2,
    "thumb_mcp_abduction": 3,
    "thumb_ip": 4,
    "mcp_flexion": 0,
    "mcp_abduction": 1,
    "pip": 2,
    "dip": 4,
}
_DLR_HIT_SLOT_OF = {"thumb_cmc_abduction": 1, "thumb_mcp_flexion": 0, "thumb_ip": 2}
_MIDDLE, _DISTAL = 2, 4


@dataclass(frozen=True, slots=True)
class Chain:
    """Which joint turns what. S = 5 slots: flexion 1, abduction 1, flexion 2, abduction 2, flexion 3.

    Attributes:
        joint: Driven joint of each slot, -1 for none, (5, S).
        links: Three bones of each digit, m, and how far flexion 3 follows flexion 2 where nothing drives it,
            (5, 4).
    """

    joint: Int64
    links: Float64


def hand_chain(joint_names: tuple[str, ...], geometry: HandGeometry) -> Chain:
    """A worn device: the patient's own hand; a finger's DIP follows its PIP at 2/3 unless it is driven.

    Raises:
        Refused: A joint is not one of the hand's.
    """
    return _chain(joint_names, _SLOT_OF, geometry.bones_m, DIP_PER_PIP, thumb_follows=False)


def dlr_hit_chain(joint_names: tuple[str, ...]) -> Chain:
    """The DLR-HIT-Hand II: five equal fingers, DIP = PIP; the thumb is one of them.

    Raises:
        Refused: A joint is not one of the hand's.
    """
    bones: Float64 = np.tile(np.array(LINKS_M), (len(DIGITS), 1))
    return _chain(joint_names, _SLOT_OF | _DLR_HIT_SLOT_OF, bones, 1.0, thumb_follows=True)


def _chain(
    names: tuple[str, ...], slots: dict[str, int], bones_m: Float64, ratio: float, *, thumb_follows: bool
) -> Chain:
    joint: Int64 = np.full((len(DIGITS), 5), -1, dtype=np.int64)
    for column, name in enumerate(names):
        digit, _, part = name.partition("_")
        slot = slots.get(name, slots.get(part, -1))
        if digit not in DIGITS or slot < 0:
            raise Refused("joint", name, "a joint of the hand", "rebuild the plan for this device")
        joint[DIGITS.index(digit), slot] = column
    follows = (joint[:, _DISTAL] < 0) & (joint[:, _MIDDLE] >= 0)
    follows[0] &= thumb_follows
    links: Float64 = np.zeros((len(DIGITS), 4))
    links[:, :3], links[:, 3] = bones_m, ratio * follows
    return Chain(joint, links)


@compiled
def digit_kinematics(q_rad: Float64, joint: Int64, links: Float64, digit: int, out: Float64) -> None:
    """Fingertip of one digit, and how each slot moves it.

    Args:
        q_rad: Driven joints, (J,).
        joint: ``Chain.joint``.
        links: ``Chain.links``.
        digit: Which one.
        out: Row 0: the tip seen from the digit's base, palmar, radial, distal; rows 1 to 5: its derivative by
            the angle of each slot, m/rad, that of flexion 2 with what follows it. (6, 3).
    """
    flex1, abduct1 = _turn(q_rad, joint[digit, 0]), _turn(q_rad, joint[digit, 1])
    flex2, abduct2 = _turn(q_rad, joint[digit, 2]), _turn(q_rad, joint[digit, 3])
    follow = links[digit, 3]
    flex3 = _turn(q_rad, joint[digit, 4]) + follow * flex2
    # the two distal bones in the frame of the first: Rx(-abduction 2) Ry(flexion 2), then flexion 3
    far_x, far_d = links[digit, 2] * math.sin(flex2 + flex3), links[digit, 2] * math.cos(flex2 + flex3)
    x = links[digit, 1] * math.sin(flex2) + far_x  # palmar
    d = links[digit, 1] * math.cos(flex2) + far_d  # along the abducted bone
    s2, c2 = math.sin(abduct2), math.cos(abduct2)
    y, z = s2 * d, links[digit, 0] + c2 * d
    s0, c0, s1, c1 = math.sin(flex1), math.cos(flex1), math.sin(abduct1), math.cos(abduct1)
    _into_base(out, 0, x, y, z, s0, c0, s1, c1)
    out[1, 0] = c0 * z - s0 * x
    out[1, 1], out[1, 2] = -s1 * out[0, 0], -c1 * out[0, 0]
    out[2, 0], out[2, 1], out[2, 2] = 0.0, out[0, 2], -out[0, 1]
    dx, dd = d + follow * far_d, x + follow * far_x
    _into_base(out, 3, dx, -s2 * dd, -c2 * dd, s0, c0, s1, c1)
    _into_base(out, 4, 0.0, c2 * d, -s2 * d, s0, c0, s1, c1)
    _into_base(out, 5, far_d, -s2 * far_x, -c2 * far_x, s0, c0, s1, c1)


@compiled
def _turn(q_rad: Float64, column: int) -> float:
    return q_rad[column] if column >= 0 else 0.0


@compiled
def _into_base(
    out: Float64, row: int, x: float, y: float, z: float, s0: float, c0: float, s1: float, c1: float
) -> None:
    """A row of ``out``: the vector (x, y, z) of the first bone's frame, by Rx(-abduction 1) Ry(flexion 1)."""
    along = c0 * z - s0 * x
    out[row, 0] = c0 * x + s0 * z
    out[row, 1] = c1 * y + s1 * along
    out[row, 2] = c1 * along - s1 * y
