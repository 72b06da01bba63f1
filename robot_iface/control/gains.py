"""Joint gains of the thesis and their multiples."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robot_iface.types import Float64

_PROXIMAL = (0.3, 0.02)
_DISTAL = (0.4, 0.027)
_DISTAL_JOINTS = frozenset({"pip", "dip", "ip"})


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
