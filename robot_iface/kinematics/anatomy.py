"""What human joints can do: ranges, the tendon coupling of DIP to PIP, and a hand at rest."""

from __future__ import annotations

import numpy as np

from robot_iface.types import FINGERS, JOINTS, Float64

DIP_PER_PIP = 2.0 / 3.0
"""Flexion of the distal joint per flexion of the middle one when a finger closes freely."""

_RANGES_DEG: dict[str, tuple[float, float]] = {
    "thumb_cmc_flexion": (-25.0, 45.0),
    "thumb_cmc_abduction": (-30.0, 45.0),
    "thumb_mcp_flexion": (-10.0, 65.0),
    "thumb_mcp_abduction": (-15.0, 15.0),
    "thumb_ip": (-15.0, 85.0),
    **{f"{finger}_mcp_flexion": (-20.0, 95.0) for finger in FINGERS},
    **{f"{finger}_mcp_abduction": (-22.0, 22.0) for finger in FINGERS},
    **{f"{finger}_pip": (-5.0, 112.0) for finger in FINGERS},
    **{f"{finger}_dip": (-10.0, 85.0) for finger in FINGERS},
}

JOINT_MIN_RAD: Float64 = np.deg2rad([_RANGES_DEG[joint][0] for joint in JOINTS])
JOINT_MAX_RAD: Float64 = np.deg2rad([_RANGES_DEG[joint][1] for joint in JOINTS])
"""Widest anatomical range of healthy hands, in the order of JOINTS; a patient's own is narrower."""
JOINT_MIN_RAD.setflags(write=False)
JOINT_MAX_RAD.setflags(write=False)


def couple_dip(joints_rad: Float64) -> Float64:
    """Angles whose four DIP joints follow their PIP joints, shape (..., 21)."""
    coupled = np.array(joints_rad, dtype=np.float64)
    for finger in FINGERS:
        pip = JOINTS.index(f"{finger}_pip")
        coupled[..., pip + 1] = DIP_PER_PIP * coupled[..., pip]
    return coupled
