"""From driven joints to a whole hand: the 21 angles, the fingertips, and how surely each is known."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from rehab_app.therapy.reference import whole_hand
from robot_iface.kinematics import HandGeometry, forward, jacobian
from robot_iface.types import FINGERS, JOINTS, LANDMARKS, Float64, Int64, UInt8, joint_index
from sessions.records import Status

# Angles that no encoder sees: the linkage guides abduction (assumed +-3 deg), the tendons couple DIP to PIP
# (assumed +-5 deg). They are ESTIMATED in the file, and their spread is carried to the fingertips.
UNSEEN_STD_RAD = math.radians(3.0)
COUPLED_STD_RAD = math.radians(5.0)
_TIPS = np.array([LANDMARKS.index(f"{digit}_tip") for digit in ("thumb", *FINGERS)])
_PIP = np.array([JOINTS.index(f"{finger}_pip") for finger in FINGERS])


@dataclass(frozen=True, slots=True)
class Poses:
    """Hands at N instants.

    Attributes:
        joints_rad: Angles in the order of JOINTS, shape (N, 21).
        landmarks_m: Landmarks in the palm frame, shape (N, 25, 3).
        fingertips_m: Fingertips in the palm frame, shape (N, 5, 3).
    """

    joints_rad: Float64
    landmarks_m: Float64
    fingertips_m: Float64


class WornHand:
    """The patient's hand in the robot: what its encoders say of the hand as a whole.

    Args:
        geometry: The patient's hand.
        driven_joints: The J joints that the robot drives and measures.
        encoder_std_rad: Standard deviation of a joint reading.
    """

    def __init__(
        self, geometry: HandGeometry, driven_joints: tuple[str, ...], encoder_std_rad: float
    ) -> None:
        self.geometry = geometry
        self._driven_joints = driven_joints
        self.driven: Int64 = joint_index(driven_joints)
        self.status: UInt8 = np.full(21, Status.ESTIMATED, dtype=np.uint8)
        self.status[self.driven] = Status.MEASURED
        self.std_rad: Float64 = np.full(21, UNSEEN_STD_RAD)
        self.std_rad[_PIP + 1] = COUPLED_STD_RAD
        self.std_rad[self.driven] = encoder_std_rad

    def joints(self, driven_rad: Float64) -> Float64:
        """All 21 angles from the driven ones: DIP = 2/3 PIP where it is not driven, the rest straight.

        Args:
            driven_rad: Angles of the driven joints, shape (N, J).

        Returns:
            Angles in the order of JOINTS, shape (N, 21).
        """
        return whole_hand(driven_rad, self._driven_joints)

    def poses(self, driven_rad: Float64) -> Poses:
        """Whole hands from driven joints, shape (N, J)."""
        joints = self.joints(driven_rad)
        landmarks = forward(self.geometry, joints).landmarks_m
        return Poses(joints, landmarks, landmarks[:, _TIPS])

    def fingertip_std_m(self, joints_rad: Float64) -> Float64:
        """Standard deviation of the fingertips per axis, carried over from the angles.

        Args:
            joints_rad: Angles in the order of JOINTS, shape (N, 21).

        Returns:
            Shape (N, 5), m.
        """
        derivative = jacobian(self.geometry, joints_rad)[:, _TIPS]
        variance = np.einsum("ntcj,j->ntc", derivative**2, self.std_rad**2)
        return np.sqrt(variance.mean(axis=2))
