"""Who did the work: robot's share, work, interaction torque, and the stiffness that was used."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from sessions.metrics.metric import Estimate
from sessions.records.fields import Float64

FLOOR_NM = 0.01
"""Below this rms interaction torque what is left is friction and noise: nobody can tell who worked."""
NOTHING_NM = 5e-4
"""Below this the robot did nothing: its share is 0."""
MOVED_RAD = math.radians(3.0)
"""A joint that turned less than this did not take part."""
NOT_SEPARABLE = "not separable from recoil and spasm: no passive curve of this day"


@dataclass(frozen=True, slots=True)
class Work:
    """Work at one joint over some stretch of time.

    Attributes:
        robot_j: Work that the robot did on the joint.
        returned_j: Work that the hand did on the robot.
        proven_patient_j: The least of it that cannot be recoil: what came back before it was put in.
    """

    robot_j: float
    returned_j: float
    proven_patient_j: float


def work(t_s: Float64, tau_interaction_nm: Float64, dq_rad_s: Float64) -> Work:
    """Integrate the power between robot and hand at one joint; as ``works``, of shape (N,)."""
    return works(t_s, tau_interaction_nm[None], dq_rad_s[None])[0]


def works(t_s: Float64, tau_interaction_nm: Float64, dq_rad_s: Float64) -> tuple[Work, ...]:
    """Integrate the power between robot and hand (rectangle rule over rows without gaps).

    A passive limb that starts relaxed can only give back what it was given, so the depth to which the
    exchanged energy falls below zero is work of the patient's own.

    Args:
        t_s: Times, shape (N,).
        tau_interaction_nm: Torque of the robot on each joint, shape (J, N), flexion positive.
        dq_rad_s: Joint speeds, shape (J, N).
    """
    if t_s.size < 2:
        return (Work(0.0, 0.0, 0.0),) * len(tau_interaction_nm)
    step = np.diff(t_s, append=t_s[-1])
    step = np.minimum(step, 3.0 * float(np.median(step)))
    energy = tau_interaction_nm * dq_rad_s
    energy *= step
    if not bool(np.isfinite(energy).all()):
        energy = np.nan_to_num(energy)
    deepest = np.cumsum(energy, axis=1).min(axis=1)
    given, returned = np.maximum(energy, 0.0).sum(axis=1), -np.minimum(energy, 0.0).sum(axis=1)
    return tuple(
        Work(float(robot), float(hand), max(0.0, -float(depth)))
        for robot, hand, depth in zip(given, returned, deepest, strict=True)
    )


def work_share(tau_robot_nm: Float64, tau_patient_nm: Float64, dq_rad_s: Float64) -> Estimate:
    """Robot's share where the patient's own torque is known (today's passive curve subtracted).

    int max(0, tau_r q') / (int max(0, tau_r q') + int max(0, tau_p q')). Work against the movement
    (resisting) takes no part in it.

    Args:
        tau_robot_nm: Torque of the robot, shape (N,) or (N, J), on a uniform grid.
        tau_patient_nm: Torque of the patient, same shape.
        dq_rad_s: Joint speed, same shape.
    """
    robot = float(np.sum(np.maximum(0.0, tau_robot_nm * dq_rad_s)))
    patient = float(np.sum(np.maximum(0.0, tau_patient_nm * dq_rad_s)))
    if not robot + patient > 0:
        return Estimate.missing("no work was done")
    return Estimate(robot / (robot + patient))


def robot_share(joints: list[Work], rms_interaction_nm: float, moved_rad: float) -> Estimate:
    """Robot's share from the interaction alone, over several joints.

    Without a passive curve the patient's work is known only within bounds: at least what is proven, at most
    all that came back. The value takes the least (so a passive limb gives 1), the interval spans both.

    Args:
        joints: Work per joint, of joints that moved.
        rms_interaction_nm: Rms of the interaction torque over those joints while they moved.
        moved_rad: Largest excursion among the joints.
    """
    if moved_rad < MOVED_RAD or not joints:
        return Estimate.missing("no joint moved by 3 degrees")
    if rms_interaction_nm < NOTHING_NM:
        return Estimate(0.0, None, "the robot applied no torque")
    if rms_interaction_nm < FLOOR_NM:
        return Estimate.missing("the robot's torque stayed below its floor of 0.01 Nm")
    robot = sum(item.robot_j for item in joints)
    least = sum(item.proven_patient_j for item in joints)
    most = max(least, sum(item.returned_j for item in joints))
    if not robot + least > 0:
        return Estimate.missing("no work was done")
    return Estimate(robot / (robot + least), (robot / (robot + most), robot / (robot + least)), NOT_SEPARABLE)
