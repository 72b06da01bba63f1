"""Limits of a robot that nobody wears: what it can do itself, within what the supervisor trips on."""

from __future__ import annotations

import numpy as np

from robot_iface.safety.shipped import THERAPIST_CAP_NM
from robot_iface.types import Capabilities, Limits

_SPEED_RAD_S = float(np.deg2rad(120.0))
"""Below the speed of 200 degrees/s that trips the supervisor, with room for the controller's own error."""


def own_limits(device: Capabilities) -> Limits:
    """Range, speed and torque of a device with no hand in it.

    Its joints meet no patient: the interaction limit only bounds what an object that it touches would bear.

    Args:
        device: What it is and can do.
    """
    ones = np.ones(len(device.joint_names))
    return Limits(
        q_min_rad=device.q_min_rad.copy(),
        q_max_rad=device.q_max_rad.copy(),
        flexion_speed_rad_s=ones * _SPEED_RAD_S,
        extension_speed_rad_s=ones * _SPEED_RAD_S,
        tau_interaction_nm=ones * THERAPIST_CAP_NM,
        tau_nm=device.tau_max_nm.copy(),
    )
