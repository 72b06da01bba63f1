"""The limits that ship: proposed values that a clinician signs, shown and editable by a therapist."""

from __future__ import annotations

import dataclasses

import numpy as np

from robot_iface.errors import Refused
from robot_iface.types import Float64, Limits

MOTOR_CAP_NM = 0.6
"""No joint is ever commanded more, whoever asks."""
THERAPIST_CAP_NM = 0.45
"""Highest interaction torque to which a therapist may raise a joint."""
_INTERACTION_NM = {"mcp": 0.25, "cmc": 0.25, "pip": 0.15, "dip": 0.08, "ip": 0.10}
_FLEXION_DEG_S = 60.0
_EXTENSION_DEG_S = 30.0
_SPASTIC_EXTENSION_DEG_S = 15.0


def shipped_limits(
    joint_names: tuple[str, ...],
    q_min_rad: Float64,
    q_max_rad: Float64,
    *,
    spastic: bool = False,
    halved: bool = False,
    hyperextension: bool = False,
) -> Limits:
    """Limits by default for one patient today.

    No standard gives a torque per finger joint; these are proposals [P]: MCP and thumb CMC 0.25, PIP 0.15,
    DIP 0.08, thumb IP 0.10 Nm; 60 deg/s into flexion, 30 into extension, 15 with spasticity (Modified
    Ashworth 1+ or more).

    Args:
        joint_names: The J driven joints.
        q_min_rad: Lower end of today's measured range, (J,).
        q_max_rad: Upper end of today's measured range, (J,).
        spastic: Modified Ashworth 1+ or more.
        halved: Insensate skin, rheumatoid arthritis or complex regional pain syndrome: torques are halved.
        hyperextension: Whether flexion joints may be moved below 0 degrees (by default they may not).

    Returns:
        Limits of the driven joints.

    Raises:
        Refused: If a joint is left without a range.
    """
    low = np.array(q_min_rad, dtype=np.float64)
    high = np.array(q_max_rad, dtype=np.float64)
    if not hyperextension:
        low = np.where([_hyperextends(name) for name in joint_names], np.maximum(low, 0.0), low)
    for name, lower, upper in zip(joint_names, low.tolist(), high.tolist(), strict=True):
        if not lower < upper:
            span = f"{np.rad2deg(lower):.1f} to {np.rad2deg(upper):.1f} degrees"
            raise Refused(f"range of {name}", span, "a range that opens", "measure today's range again")
    interaction = np.array([_INTERACTION_NM[_joint_class(name)] for name in joint_names])
    extension = _SPASTIC_EXTENSION_DEG_S if spastic else _EXTENSION_DEG_S
    ones = np.ones(len(joint_names))
    return Limits(
        q_min_rad=low,
        q_max_rad=high,
        flexion_speed_rad_s=ones * np.deg2rad(_FLEXION_DEG_S),
        extension_speed_rad_s=ones * np.deg2rad(extension),
        tau_interaction_nm=interaction * (0.5 if halved else 1.0),
        tau_nm=ones * MOTOR_CAP_NM,
    )


def raised_limits(limits: Limits, joint_names: tuple[str, ...], joint: str, tau_nm: float) -> Limits:
    """Limits with another interaction torque at one joint: a therapist's act, the only way to more.

    Args:
        limits: Present limits.
        joint_names: The J driven joints.
        joint: Which of them.
        tau_nm: Its interaction torque from now on.

    Raises:
        Refused: The joint is not driven, or the torque is above what a therapist may allow.
    """
    if joint not in joint_names:
        raise Refused("joint", joint, "one of " + ", ".join(joint_names), "choose one of these")
    if not 0.0 < tau_nm <= THERAPIST_CAP_NM:
        bound = f"above 0, at most {THERAPIST_CAP_NM:g} Nm"
        raise Refused(f"interaction torque of {joint}", f"{tau_nm:g} Nm", bound, "ask for less")
    torques = limits.tau_interaction_nm.copy()
    torques[joint_names.index(joint)] = tau_nm
    return dataclasses.replace(limits, tau_interaction_nm=torques)


def _joint_class(name: str) -> str:
    """The anatomical joint of a joint name: ``index_mcp_flexion`` -> ``mcp``."""
    return name.split("_")[1]


def _hyperextends(name: str) -> bool:
    """Whether values below 0 degrees are hyperextension (not so for abduction and the thumb's CMC)."""
    return not name.endswith("_abduction") and _joint_class(name) != "cmc"
