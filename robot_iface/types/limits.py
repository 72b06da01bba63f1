"""Bounds of the lowest layer: box, coupled ranges, speeds, torques, and until when they hold."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robot_iface.errors import Refused
from robot_iface.types.hand import Float64


@dataclass(frozen=True, slots=True)
class Hull:
    """The convex set that two joints of a digit may share.

    Attributes:
        joints: Names of the two joints, usually MCP flexion and PIP of one finger.
        corners_rad: Corners in (first, second) joint angles, counter-clockwise, convex, (K, 2), K >= 3.
    """

    joints: tuple[str, str]
    corners_rad: Float64

    def __post_init__(self) -> None:
        corners = self.corners_rad
        if corners.ndim != 2 or corners.shape[0] < 3 or corners.shape[1] != 2:
            raise Refused("hull", f"of shape {corners.shape}", "(3 or more, 2)", "measure the range again")
        ahead = np.roll(corners, -1, axis=0) - corners
        turn = ahead[:, 0] * np.roll(ahead, -1, axis=0)[:, 1] - ahead[:, 1] * np.roll(ahead, -1, axis=0)[:, 0]
        if not bool((turn > 0.0).all()):
            names = " and ".join(self.joints)
            raise Refused(f"hull of {names}", "not convex", "convex", "measure the range again")


@dataclass(frozen=True, slots=True)
class Limits:
    """Bounds that the lowest layer enforces. Arrays are (J,) over the driven joints.

    Attributes:
        q_min_rad: Lower end of today's range.
        q_max_rad: Upper end of today's range.
        flexion_speed_rad_s: Highest commanded speed into flexion.
        extension_speed_rad_s: Highest commanded speed into extension.
        tau_interaction_nm: Highest torque between device and patient.
        tau_nm: Highest commanded motor torque.
        tau_rate_nm_s: Highest change of commanded torque.
        power_w: Highest mechanical power per joint.
        trip_speed_rad_s: Measured speed that trips the supervisor.
        margin_rad: How far outside the range a joint may be seen before it trips.
        hulls: Joint pairs whose common range is narrower than a box (tightness couples MCP and PIP).
        measured_utc_ns: When they were measured on the patient; 0 for the shipped defaults.
        expires_utc_ns: When they cease to hold; 0 for never.
        wrist_rad: Wrist extension at which they were measured; NaN for any.
    """

    q_min_rad: Float64
    q_max_rad: Float64
    flexion_speed_rad_s: Float64
    extension_speed_rad_s: Float64
    tau_interaction_nm: Float64
    tau_nm: Float64
    tau_rate_nm_s: float = 60.0
    power_w: float = 2.0
    trip_speed_rad_s: float = float(np.deg2rad(200.0))
    margin_rad: float = float(np.deg2rad(2.0))
    hulls: tuple[Hull, ...] = ()
    measured_utc_ns: int = 0
    expires_utc_ns: int = 0
    wrist_rad: float = float("nan")
