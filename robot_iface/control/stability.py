"""Whether gains keep a sampled joint stable, asked before anything moves."""

from __future__ import annotations

from robot_iface.control.gains import FINGERTIP_N_M, Gains, nominal_gains
from robot_iface.errors import Refused
from robot_iface.types import Float64, Space

JOINT_DAMPING_NMS_RAD = 1e-4
"""Physical damping b of a bare joint."""
DELAY_TICKS = 1.0
"""Delay t_d, in control periods, that is reckoned with."""
STIFFNESS_SHARE, DAMPING_SHARE = 0.5, 0.7
MULTIPLE_RANGE = (0.1, 10.0)
FINGERTIP_RANGE_N_M = (100.0, 800.0)


def stiffness_bound_nm_rad(damping_nms_rad: Float64, period_s: float) -> Float64:
    """Half the bound of Gil and Hulin, K < (b + D) / (T/2 + t_d), (J,).

    D is the loop's own damping. The straps add some, but only while a hand is inside, so they do not count.

    Args:
        damping_nms_rad: D, (J,).
        period_s: Control period T.
    """
    delay_s = (0.5 + DELAY_TICKS) * period_s
    return STIFFNESS_SHARE * (JOINT_DAMPING_NMS_RAD + damping_nms_rad) / delay_s


def damping_bound_nms_rad(period_s: float, inertia_kg_m2: float) -> float:
    """D < 0.7 M / T, with one tick of delay.

    Args:
        period_s: Control period T.
        inertia_kg_m2: Least inertia M of a joint, reflected (``Capabilities.inertia_kg_m2``).
    """
    return DAMPING_SHARE * inertia_kg_m2 / period_s


def check_gains(
    multiple: float, space: Space, names: tuple[str, ...], period_s: float, inertia_kg_m2: float
) -> None:
    """Pass if a prescribed stiffness is in its range and stable on any joint.

    K grows with the multiple n and D with its root, so that what passes at n passes at every smaller one.

    Args:
        multiple: n.
        space: Where the impedance acts.
        names: The J driven joints.
        period_s: Control period.
        inertia_kg_m2: Least inertia of a joint of the device.

    Raises:
        Refused: It is out of range or would be unstable: joint, value, bound.
    """
    remedy = "prescribe a lower stiffness multiple"
    low, high = MULTIPLE_RANGE
    if not low <= multiple <= high:
        raise Refused("stiffness multiple", f"{multiple:g}", f"{low:g} to {high:g}", remedy)
    low, high = FINGERTIP_RANGE_N_M
    stiffness_n_m = FINGERTIP_N_M * multiple
    if space == "fingertip" and not low <= stiffness_n_m <= high:
        bound = f"{low:g} to {high:g} N/m (stiffness multiple 1 to 8)"
        raise Refused("fingertip stiffness", f"{stiffness_n_m:g} N/m", bound, "prescribe one in this range")
    check_joint_gains(nominal_gains(names, space).scaled(multiple), names, period_s, inertia_kg_m2)


def check_joint_gains(gains: Gains, names: tuple[str, ...], period_s: float, inertia_kg_m2: float) -> None:
    """Pass if each joint's gains are stable.

    Args:
        gains: K and D of each joint.
        names: The J driven joints.
        period_s: Control period.
        inertia_kg_m2: Least inertia of a joint of the device.

    Raises:
        Refused: One would be unstable: joint, value, bound.
    """
    most_d = damping_bound_nms_rad(period_s, inertia_kg_m2)
    most_k: Float64 = stiffness_bound_nm_rad(gains.damping_nms_rad, period_s)
    at = f"at {period_s * 1e3:g} ms"
    remedy = "prescribe a lower stiffness multiple"
    for column, name in enumerate(names):
        stiffness, bound = float(gains.stiffness_nm_rad[column]), float(most_k[column])
        damping = float(gains.damping_nms_rad[column])
        if not damping < most_d:
            limit = f"below {most_d:.3g} Nms/rad {at}"
            raise Refused(f"damping of {name}", f"{damping:.3g} Nms/rad", limit, remedy)
        if not stiffness < bound:
            limit = f"below {bound:.3g} Nm/rad {at}"
            raise Refused(f"stiffness of {name}", f"{stiffness:.3g} Nm/rad", limit, remedy)
