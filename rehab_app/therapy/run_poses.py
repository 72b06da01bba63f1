"""From driven joints to a whole hand: the 21 angles, the fingertips, and how surely each is known."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from rehab_app.hand.retarget import ROBOT_JOINTS, whole_robot_hand
from rehab_app.therapy.reference_place import whole_hand
from robot_iface.kinematics import HandGeometry, average_hand, forward, jacobian
from robot_iface.kinematics.dlr_hit import LINKS_M, dlr_hit_hand, hand_points
from robot_iface.types import (
    FINGERS,
    JOINTS,
    LANDMARKS,
    Capabilities,
    Float64,
    Int64,
    UInt8,
    joint_index,
)
from sessions.errors import Refused
from sessions.records import Status

# Angles that no encoder sees: the linkage guides abduction (assumed +-3 deg), the tendons couple DIP to PIP
# (assumed +-5 deg). They are ESTIMATED in the file, and their spread is carried to the fingertips.
UNSEEN_STD_RAD = math.radians(3.0)
COUPLED_STD_RAD = math.radians(5.0)
_TIPS = np.array([LANDMARKS.index(f"{digit}_tip") for digit in ("thumb", *FINGERS)])
_NUDGE_RAD = 1e-5
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


class RunHand(Protocol):
    """What moved in a run: what the device's encoders say of a hand as a whole."""

    @property
    def status(self) -> UInt8:
        """How each of the 21 angles came about, shape (21,)."""
        ...

    @property
    def std_rad(self) -> Float64:
        """Standard deviation of each angle, shape (21,)."""
        ...

    def poses(self, driven_rad: Float64) -> Poses:
        """Whole hands from the driven joints, shape (N, J)."""
        ...

    def fingertip_std_m(self, joints_rad: Float64) -> Float64:
        """Standard deviation of the fingertips per axis, shape (N, 5), from all angles (N, 21)."""
        ...


def run_hand(device: Capabilities, geometry: HandGeometry) -> RunHand:
    """The hand whose movement a run on a device records.

    Args:
        device: The device: one that is worn moves the patient's hand, one with a chain of its own itself.
        geometry: The patient's hand.

    Raises:
        Refused: The device's joints are not those of its chain.
    """
    if device.chain == "hand":
        return WornHand(geometry, device.joint_names, device.encoder_std_rad)
    if device.joint_names != ROBOT_JOINTS:
        names = ", ".join(device.joint_names[:3])
        raise Refused("robot joints", f"{names} ...", "those of its chain", "update the device")
    return BareRobot(device.encoder_std_rad)


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


class BareRobot:
    """The DLR-HIT-Hand II on its own, which nobody wears: its encoders see all of it.

    Points are those of its own chain in its palm frame (x palmar, y radial, z distal, a right hand). Human
    joints that it does not have stand at 0 without spread; its DIP joints are geared to its PIP joints.

    Args:
        encoder_std_rad: Standard deviation of a joint reading.
    """

    def __init__(self, encoder_std_rad: float) -> None:
        self._hand = dlr_hit_hand()
        length_m = float(np.linalg.norm(self._hand.bases_m[2])) + sum(LINKS_M)
        self._palm_m = average_hand(length_m).palm_m
        own = joint_index(ROBOT_JOINTS)
        self.status: UInt8 = np.full(len(JOINTS), Status.ESTIMATED, dtype=np.uint8)
        self.status[own] = Status.MEASURED
        self.std_rad: Float64 = np.zeros(len(JOINTS))
        self.std_rad[own] = encoder_std_rad
        self.std_rad[_PIP + 1] = encoder_std_rad

    def poses(self, driven_rad: Float64) -> Poses:
        """The robot's postures (N, 15) as whole hands."""
        points = hand_points(self._hand, driven_rad.reshape(-1, 5, 3)).reshape(-1, 20, 3)
        palm = np.broadcast_to(self._palm_m, (len(points), 5, 3))
        landmarks = np.concatenate([points, palm], axis=1)
        return Poses(whole_robot_hand(driven_rad), landmarks, landmarks[:, _TIPS])

    def fingertip_std_m(self, joints_rad: Float64) -> Float64:
        """Standard deviation of the fingertips per axis, shape (N, 5), from all angles (N, 21)."""
        own = joint_index(ROBOT_JOINTS)
        driven, std = joints_rad[:, own], self.std_rad[own]
        variance = np.zeros((len(driven), 5))
        for column in range(own.size):
            nudge = np.zeros(own.size)
            nudge[column] = _NUDGE_RAD
            slope = (self.poses(driven + nudge).fingertips_m - self.poses(driven).fingertips_m) / _NUDGE_RAD
            variance += (slope**2).mean(axis=2) * std[column] ** 2
        return np.sqrt(variance)
