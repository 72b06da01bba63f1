"""A person's hand fitted to markers: pose, joints and fingertips with covariance, gaps as gaps."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from rehab_app.geometry.rotation import matrix_from_wxyz, wxyz_from_matrix
from rehab_app.hand.marker_model import MarkerModel
from rehab_app.hand.pose_prior import JointPrior, rest_prior
from rehab_app.hand.pose_problem import PoseProblem, PoseState
from rehab_app.hand.pose_solver import solve, solve_from_nothing
from rehab_app.hand.pose_uncertainty import JOINT_DIGIT, estimated_noise, joint_uncertainty
from rehab_app.hand.protocol import MarkerProtocol, load_protocol
from rehab_app.hand.subject import Subject
from sessions.errors import Refused
from sessions.records import Status
from sessions.records.fields import Float64, Int64, UInt8

FEWEST_MARKERS = 3
"""Markers without which a frame says nothing of where the hand is."""


@dataclass(frozen=True, slots=True)
class HandFit:
    """The hand in N frames. What nothing was seen of is NaN and LOST.

    Attributes:
        p_palm_m: Palm origin in the camera frame, shape (N, 3).
        q_wxyz: Rotation from palm to camera, shape (N, 4).
        joints_rad: Joint angles, shape (N, 21).
        joint_covariance_rad2: Their covariance, shape (N, 21, 21).
        joint_status: Status of each joint, shape (N, 21).
        fingertips_palm_m: Fingertips in the palm frame, shape (N, 5, 3).
        fingertip_covariance_m2: Their covariance in the palm frame, shape (N, 5, 3, 3).
        residual_m: rms distance of fitted from seen markers, shape (N,).
        size: Factor on the hand's size in the frame, 1 for real markers, shape (N,).
        noise_m: Standard deviation of each marker's position per axis that the covariance rests on, (M,);
            NaN where it was stated per frame.
    """

    p_palm_m: Float64
    q_wxyz: Float64
    joints_rad: Float64
    joint_covariance_rad2: Float64
    joint_status: UInt8
    fingertips_palm_m: Float64
    fingertip_covariance_m2: Float64
    residual_m: Float64
    size: Float64
    noise_m: Float64


class PoseFitter:
    """Fits one subject's hand.

    Args:
        subject: The person, calibrated or of average proportions.
        protocol: The markers.
    """

    def __init__(self, subject: Subject, protocol: MarkerProtocol) -> None:
        self.model = MarkerModel(subject, protocol)
        self._tips = fingertips_of(subject)

    def fit(
        self,
        p_m: Float64,
        sigma_m: Float64 | float | None = None,
        initial: HandFit | None = None,
        prior: JointPrior | None = None,
    ) -> HandFit:
        """Fit the hand to each frame by itself.

        Args:
            p_m: Marker positions in the camera frame, NaN where unseen, shape (N, M, 3).
            sigma_m: Standard deviation of a position per axis, () or (M,) or (N, M) or (N, M, 3). Left out,
                it is estimated from the residuals of all frames, marker by marker.
            initial: Poses to begin from (a tracker's last), N of them; NaN angles begin at the prior's.
            prior: Expected angles, such as a tracker's prediction. Without it a weak prior of a hand at rest
                holds, and a digit without any marker is LOST; with it, such a digit is ESTIMATED.
        """
        if p_m.ndim != 3 or p_m.shape[1:] != (len(self.model.anchors), 3):
            raise Refused(
                "markers",
                f"of shape {p_m.shape}",
                f"(frames, {len(self.model.anchors)}, 3)",
                "follow the protocol",
            )
        problem = self._problem(p_m, sigma_m, prior)
        usable = np.flatnonzero((problem.precision > 0).all(axis=2).sum(axis=1) >= FEWEST_MARKERS)
        part = problem.at(usable)
        state = self._solved(part, None if initial is None else (initial, usable))
        noise_m = np.full(p_m.shape[1], np.nan)
        if sigma_m is None and usable.size:
            noise_m = estimated_noise(part, state)
            precision = np.where(problem.precision > 0, 1.0 / noise_m[:, None] ** 2, 0.0)
            problem = replace(problem, precision=precision)
            part = problem.at(usable)
            state, _ = solve(part, state, 8)
        elif sigma_m is not None and np.ndim(sigma_m) < 2:
            noise_m[:] = sigma_m
        return self._described(part, state, usable, len(p_m), noise_m, given=prior is not None)

    def _problem(
        self, p_m: Float64, sigma_m: Float64 | float | None, prior: JointPrior | None
    ) -> PoseProblem:
        sigma = np.asarray(self.model.protocol.noise_m if sigma_m is None else sigma_m, dtype=np.float64)
        if sigma.ndim in (1, 2):
            sigma = sigma[..., None]
        seen = np.isfinite(p_m).all(axis=2, keepdims=True)
        precision = np.where(seen, np.broadcast_to(1.0 / sigma**2, p_m.shape), 0.0)
        return PoseProblem(self.model, np.where(seen, p_m, 0.0), precision, prior or rest_prior(len(p_m)))

    def _solved(self, problem: PoseProblem, initial: tuple[HandFit, Int64] | None) -> PoseState:
        if not len(problem.p_m) or initial is None:
            return solve_from_nothing(problem) if len(problem.p_m) else _no_state()
        fit, rows = initial
        known = np.isfinite(fit.p_palm_m[rows]).all(axis=1)
        if not bool(known.all()):
            return solve_from_nothing(problem)
        joints = fit.joints_rad[rows]
        start = PoseState(
            matrix_from_wxyz(fit.q_wxyz[rows]),
            fit.p_palm_m[rows],
            np.where(np.isfinite(joints), joints, problem.prior.joints_rad),
            np.log(fit.size[rows]),
        )
        return solve(problem, start, 12)[0]

    def _described(
        self,
        problem: PoseProblem,
        state: PoseState,
        usable: Int64,
        frames: int,
        noise_m: Float64,
        *,
        given: bool,
    ) -> HandFit:
        """Covariance, status and fingertips of solved frames, laid among those in which nothing was seen."""
        covariance, status = joint_uncertainty(problem, state, given=given)
        placed = self._tips.place(state.joints_rad)
        tips = placed.p_m * self._tips.mirror
        slopes = self._tips.right_jacobian(placed) * self._tips.mirror[:, None]
        tip_covariance = slopes @ covariance[:, None] @ np.swapaxes(slopes, -1, -2)
        lost = status == Status.LOST
        covariance[lost[:, :, None] | lost[:, None, :]] = np.nan
        lost_tip = np.stack([lost[:, JOINT_DIGIT == digit].any(axis=1) for digit in range(5)], axis=1)
        tips[lost_tip], tip_covariance[lost_tip] = np.nan, np.nan
        residual = problem.residuals(state)
        seen = (problem.precision > 0).all(axis=2).sum(axis=1)
        return HandFit(
            _laid(usable, frames, state.p_m),
            _laid(usable, frames, wxyz_from_matrix(state.rotation)),
            _laid(usable, frames, np.where(lost, np.nan, state.joints_rad)),
            _laid(usable, frames, covariance),
            _laid(usable, frames, status.astype(np.float64), 0.0).astype(np.uint8),
            _laid(usable, frames, tips),
            _laid(usable, frames, tip_covariance),
            _laid(usable, frames, np.sqrt((residual**2).sum(axis=(1, 2)) / np.maximum(seen, 1))),
            _laid(usable, frames, np.exp(state.log_size)),
            noise_m,
        )


def fingertips_of(subject: Subject) -> MarkerModel:
    """The five fingertips as markers that sit exactly on them."""
    protocol = load_protocol("fingertips5")
    return MarkerModel(Subject(subject.geometry, protocol.names, np.zeros((5, 3))), protocol)


def _no_state() -> PoseState:
    return PoseState(np.zeros((0, 3, 3)), np.zeros((0, 3)), np.zeros((0, 21)), np.zeros(0))


def _laid(rows: Int64, frames: int, values: Float64, empty: float = np.nan) -> Float64:
    result = np.full((frames, *values.shape[1:]), empty)
    result[rows] = values
    return result
