"""Gains of the thesis, of the fingertip law, and their multiples."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robot_iface.types import Float64, Space

_PROXIMAL = (0.3, 0.02)
_DISTAL = (0.4, 0.027)
_DISTAL_JOINTS = frozenset({"pip", "dip", "ip"})
FINGERTIP_N_M = 100.0
"""Stiffness at a fingertip at multiple 1, alike in all directions."""
TIP_MASS_KG = 0.06
"""What the damping at a fingertip is laid out for."""
DAMPING_RATIO = 0.7
_WEAK = (0.03, 0.0063)  # critically damped for a rotor of 3.3e-4 kg m^2, as the thesis's gains are
# How far a joint of a straight digit moves its fingertip, with what follows it: a hand of 210 mm, or the
# DLR-HIT-Hand II, whose thumb is a finger.
_ARM_M = {"cmc": 0.129, "mcp": 0.116, "pip": 0.076, "dip": 0.025, "ip": 0.076}


@dataclass(frozen=True, slots=True)
class Gains:
    """Joint stiffness and damping, (J,).

    Attributes:
        stiffness_nm_rad: K.
        damping_nms_rad: D.
    """

    stiffness_nm_rad: Float64
    damping_nms_rad: Float64

    def scaled(self, multiple: Float64 | float) -> Gains:
        """Gains at a multiple n, a number or (J,): K by n and D by sqrt(n), which keeps the damping ratio."""
        return Gains(self.stiffness_nm_rad * multiple, self.damping_nms_rad * np.sqrt(multiple))


def thesis_gains(joint_names: tuple[str, ...]) -> Gains:
    """Gains of the thesis (section 5.2): 0.3 Nm/rad and 0.02 Nms/rad at MCP, 0.4 and 0.027 at PIP.

    The thumb likewise: CMC and MCP as MCP, IP as PIP. They are critically damped for a rotor inertia of about
    3.3e-4 to 4.6e-4 kg m^2.

    Args:
        joint_names: The J driven joints.
    """
    rows = [_DISTAL if name.split("_")[1] in _DISTAL_JOINTS else _PROXIMAL for name in joint_names]
    return Gains(np.array([row[0] for row in rows]), np.array([row[1] for row in rows]))


def weak_joint_gains(joints: int) -> Gains:
    """The joint spring and damper beside those at the fingertips, at multiple 1."""
    return Gains(np.full(joints, _WEAK[0]), np.full(joints, _WEAK[1]))


def nominal_gains(joint_names: tuple[str, ...], space: Space) -> Gains:
    """What a joint is given at multiple 1, at most: the thesis's gains, or those of straight digits.

    Args:
        joint_names: The J driven joints.
        space: Where the impedance acts.
    """
    if space == "joint":
        return thesis_gains(joint_names)
    square_m2: Float64 = np.array([_ARM_M[name.split("_")[1]] for name in joint_names]) ** 2
    weak = weak_joint_gains(len(joint_names))
    damping_ns_m = 2.0 * DAMPING_RATIO * float(np.sqrt(TIP_MASS_KG * FINGERTIP_N_M))
    return Gains(
        weak.stiffness_nm_rad + FINGERTIP_N_M * square_m2, weak.damping_nms_rad + damping_ns_m * square_m2
    )


def learning_share(joint_names: tuple[str, ...], space: Space) -> Float64:
    """Least stiffness of a law in any direction as a share of ``nominal_gains``, (J,).

    Learning from e by K e diverges where the hand is held by much less than K: the fingertips of straight
    digits are, by the weak joint spring alone.

    Args:
        joint_names: The J driven joints.
        space: Where the impedance acts.
    """
    if space == "joint":
        return np.ones(len(joint_names))
    nominal = nominal_gains(joint_names, space).stiffness_nm_rad
    return weak_joint_gains(nominal.size).stiffness_nm_rad / nominal
