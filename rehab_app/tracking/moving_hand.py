"""Where the hand will be at the next capture: damped constant velocity of pose and joints, and how unsure."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from rehab_app.geometry.rotation import matrix_from_wxyz, turn, wxyz_from_matrix
from rehab_app.hand.marker_model import MarkerModel
from rehab_app.hand.pose_fit import HandFit
from rehab_app.hand.pose_prior import JointPrior
from sessions.records import Status
from sessions.records.fields import Float64
from sessions.records.names import JOINTS

DAMPING = 0.85
_JOINT_NOISE_RAD = np.where([joint.endswith("abduction") for joint in JOINTS], 0.025, 0.07)
_POSE_NOISE_M = 0.003
_TURN_NOISE_RAD = 0.02
_LARGEST_STD_RAD = 0.9
_WEAK_STD_RAD = 0.25  # the fit leans on the expectation no more than this: what is seen must speak for itself
_PERIOD_NS = 1e9 / 30.0  # the noises are those of one period of 30 Hz


@dataclass(frozen=True, slots=True)
class MovingHand:
    """The hand at the last capture and its speed.

    Attributes:
        t_ns: Time of the last capture.
        fit: The hand there, one frame.
        std_rad: Standard deviation of its joints, shape (21,).
        turn_rad_ns: Angular velocity in the camera frame, shape (3,), rad/ns.
        shift_m_ns: Velocity of the palm, shape (3,), m/ns.
        joints_rad_ns: Velocity of the joints, shape (21,), rad/ns.
    """

    t_ns: int
    fit: HandFit
    std_rad: Float64
    turn_rad_ns: Float64
    shift_m_ns: Float64
    joints_rad_ns: Float64


@dataclass(frozen=True, slots=True)
class Expectation:
    """What the next capture should show.

    Attributes:
        start: The expected hand, to begin the fit from.
        prior: Expected joints for the fit, stated weaker than they are known.
        p_camera_m: Expected markers, shape (M, 3).
        covariance_m2: Their covariance, shape (M, 3, 3).
        normal_camera: Normals of the markers, shape (M, 3).
    """

    start: HandFit
    prior: JointPrior
    p_camera_m: Float64
    covariance_m2: Float64
    normal_camera: Float64


def at_rest(t_ns: int, fit: HandFit) -> MovingHand:
    """A hand of which only one capture is known, taken to stand still."""
    return MovingHand(t_ns, fit, _stds(fit), np.zeros(3), np.zeros(3), np.zeros(21))


def followed(last: MovingHand, t_ns: int, fit: HandFit) -> MovingHand:
    """The motion after another capture: its speed is the damped mean of the last and the newest."""
    span = float(t_ns - last.t_ns)
    before, now = matrix_from_wxyz(last.fit.q_wxyz[0]), matrix_from_wxyz(fit.q_wxyz[0])
    turned = now @ before.T
    axis = 0.5 * np.array(
        [turned[2, 1] - turned[1, 2], turned[0, 2] - turned[2, 0], turned[1, 0] - turned[0, 1]]
    )
    measured = fit.joint_status[0] == Status.MEASURED
    step = np.where(measured, (fit.joints_rad[0] - last.fit.joints_rad[0]) / span, 0.0)
    return MovingHand(
        t_ns,
        fit,
        _stds(fit),
        0.5 * DAMPING * (last.turn_rad_ns + axis / span),
        0.5 * DAMPING * (last.shift_m_ns + (fit.p_palm_m[0] - last.fit.p_palm_m[0]) / span),
        DAMPING * (0.3 * last.joints_rad_ns + 0.7 * step),
    )


def expect(model: MarkerModel, motion: MovingHand, t_ns: int) -> Expectation:
    """The hand and its markers at a coming time."""
    span = float(t_ns - motion.t_ns)
    periods = max(span / _PERIOD_NS, 0.1)
    coast = min(span, 3.0 * _PERIOD_NS)  # a speed is not believed for longer than three periods
    rotation = turn(motion.turn_rad_ns * coast) @ matrix_from_wxyz(motion.fit.q_wxyz[0])
    shift = motion.fit.p_palm_m[0] + motion.shift_m_ns * coast
    joints = motion.fit.joints_rad[0] + motion.joints_rad_ns * coast
    std = np.minimum(np.sqrt(motion.std_rad**2 + periods * _JOINT_NOISE_RAD**2), _LARGEST_STD_RAD)
    start = replace(
        motion.fit,
        q_wxyz=wxyz_from_matrix(rotation)[None],
        p_palm_m=shift[None],
        joints_rad=joints[None],
    )
    arms = model.positions(joints) @ rotation.T
    covariance = marker_covariance(model, joints, rotation, std)
    covariance += periods * _pose_noise(arms)
    return Expectation(
        start,
        JointPrior(joints[None], np.maximum(std, _WEAK_STD_RAD)[None]),
        arms + shift,
        covariance,
        model.normals(joints) @ rotation.T,
    )


def marker_covariance(
    model: MarkerModel, joints_rad: Float64, rotation: Float64, std_rad: Float64
) -> Float64:
    """Covariance of each marker in the camera frame that comes of the joints, shape (M, 3, 3), m^2."""
    slopes = (rotation @ model.jacobian(joints_rad)) * std_rad
    return slopes @ np.swapaxes(slopes, -1, -2)


def _pose_noise(arms_m: Float64) -> Float64:
    """Covariance of each marker that comes of the palm's moving in one period, shape (M, 3, 3), m^2."""
    square = (arms_m**2).sum(axis=1)[:, None, None] * np.eye(3) - arms_m[:, :, None] * arms_m[:, None, :]
    return _POSE_NOISE_M**2 * np.eye(3) + _TURN_NOISE_RAD**2 * square


def _stds(fit: HandFit) -> Float64:
    variance = np.diagonal(fit.joint_covariance_rad2[0])
    return np.sqrt(np.where(np.isfinite(variance), variance, _LARGEST_STD_RAD**2))
