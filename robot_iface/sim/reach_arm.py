"""A planar two-link arm in place of the MIT-Manus: where it stands, its Cartesian law, and how it is timed.

Link lengths are Table 5.1's. Its twist angles (two times -90 degrees) would fold the arm out of its plane and
are read as a misprint. The thesis does not say where the shoulder stands in the MIT-Manus frame: it is set
so that the whole path is well inside the reach.
"""

from __future__ import annotations

import numpy as np

from robot_iface.errors import Refused
from robot_iface.types import Float64

ARM_LINKS_M = (0.551, 0.407)
SHOULDER_M: Float64 = np.array([0.0, 0.65])
"""Assumed place of the shoulder in the MIT-Manus frame (x, y), m."""
START_M: Float64 = np.array([-0.1, 0.1])
END_M: Float64 = np.array([-0.0975, -0.1245])
"""Where the arm's end begins and ends its reach (section 5.2.3), m."""
WRIST_M: Float64 = np.array([0.0, -0.0545])
"""The hand's CMC from the arm's end: the flange, as the thesis's two positions differ, m."""
ARM_STIFFNESS_N_M, ARM_DAMPING_NS_M = 850.0, 50.0
REACH_S, GRASP_S, TRIAL_S = 3.0, 1.2, 5.0


def quintic(t_s: Float64 | float, duration_s: float) -> tuple[Float64, Float64]:
    """Share of a fifth-order movement and its rate, at rest before and after.

    Returns:
        Share from 0 to 1, and its derivative, 1/s; shapes as ``t_s``.
    """
    s = np.clip(np.asarray(t_s, dtype=np.float64) / duration_s, 0.0, 1.0)
    return s**3 * (10 - 15 * s + 6 * s**2), 30 * s**2 * (1 - s) ** 2 / duration_s


def cubic(t_s: Float64 | float, duration_s: float) -> tuple[Float64, Float64]:
    """As ``quintic``, of the third order."""
    s = np.clip(np.asarray(t_s, dtype=np.float64) / duration_s, 0.0, 1.0)
    return s**2 * (3 - 2 * s), 6 * s * (1 - s) / duration_s


def arm_inverse(end_m: Float64) -> Float64:
    """Shoulder and elbow that bring the arm's end to a point, elbow to the left (-x).

    Args:
        end_m: Point in the MIT-Manus frame, shape (2,).

    Raises:
        Refused: The point is out of reach.
    """
    first, second = ARM_LINKS_M
    reach = end_m - SHOULDER_M
    distance = float(np.hypot(*reach))
    if not abs(first - second) < distance < first + second:
        raise Refused(
            "distance from the shoulder",
            f"{distance:.3g} m",
            f"{abs(first - second):g} to {first + second:g} m",
            "choose a nearer point",
        )
    elbow = float(np.arccos((distance**2 - first**2 - second**2) / (2 * first * second)))
    shoulder = np.arctan2(reach[1], reach[0]) - np.arctan2(
        second * np.sin(elbow), first + second * np.cos(elbow)
    )
    return np.array([float(shoulder), elbow])


def arm_torque_nm(
    arm_rad: Float64, arm_rad_s: Float64, reference_m: Float64, reference_m_s: Float64
) -> tuple[Float64, Float64]:
    """The thesis's Cartesian PD law, tau = J^T [K (x_d - x) + D (x'_d - x')].

    Args:
        arm_rad: Shoulder and elbow, shape (2,).
        arm_rad_s: Their speeds, shape (2,).
        reference_m: Where the end should be, shape (2,).
        reference_m_s: How fast it should move, shape (2,).

    Returns:
        Torque of shoulder and elbow, and where the end is, each of shape (2,).
    """
    first, second = ARM_LINKS_M
    one, both = float(arm_rad[0]), float(arm_rad[0] + arm_rad[1])
    upper = first * np.array([np.cos(one), np.sin(one)])
    fore = second * np.array([np.cos(both), np.sin(both)])
    jacobian = np.array([[-upper[1] - fore[1], -fore[1]], [upper[0] + fore[0], fore[0]]])
    end = SHOULDER_M + upper + fore
    force = ARM_STIFFNESS_N_M * (reference_m - end) + ARM_DAMPING_NS_M * (
        reference_m_s - jacobian @ arm_rad_s
    )
    return jacobian.T @ force, end
