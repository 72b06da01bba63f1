"""How surely a fitted pose is known: noise from the residuals, covariance and status of every joint."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from rehab_app.hand.pose_prior import rest_prior
from rehab_app.hand.pose_problem import JOINT_PART, PoseProblem, PoseState
from sessions.records import DIGITS, JOINTS, Status, digit_of
from sessions.records.fields import Float64, UInt8

MEASURED_STD_RAD = 0.25
MEASURED_SHARE = 0.5
"""A joint counts as measured when the markers alone, without the DIP coupling, fix it to within this angle
and to within this share of what was known before; otherwise it is an estimate."""

JOINT_DIGIT = np.array([DIGITS.index(digit_of(joint)) for joint in JOINTS])
"""Digit of each of the 21 joints."""

_BATCH = 1024
_NOISE_FRAMES = 2000


def estimated_noise(problem: PoseProblem, state: PoseState) -> Float64:
    """Standard deviation of each marker per axis from what the fit left over, shape (M,), m.

    The pose takes up part of the noise: the residuals are grown by the share of freedom that it uses, over
    all frames together. Rows are weighted robustly, so that a swapped marker does not speak for all.
    """
    rows = np.arange(0, len(state.p_m), max(1, len(state.p_m) // _NOISE_FRAMES))
    problem, state = problem.at(rows), state.at(rows)
    information, _, weight = problem.linearised(state)
    posterior = np.linalg.inv(information + problem.prior_information(state))
    used = float(np.einsum("nij,nji->", posterior, information))
    seen = (problem.precision > 0).all(axis=2)
    count = 3.0 * float(seen.sum())
    squares = (problem.residuals(state) ** 2).sum(axis=2) * weight * seen
    variance = squares.sum(axis=0) / np.maximum(3.0 * seen.sum(axis=0), 1.0)
    # a marker that the pose can follow freely leaves no residual: it is no better than half the usual
    variance = np.maximum(variance, 0.25 * squares.sum() / count) * count / max(count - used, 0.1 * count)
    return np.sqrt(np.maximum(variance, 1e-10))


def joint_uncertainty(problem: PoseProblem, state: PoseState, *, given: bool) -> tuple[Float64, UInt8]:
    """Covariance (N, 21, 21) and status (N, 21) of the joints.

    Args:
        problem: What was seen.
        state: The poses of least cost.
        given: Whether the caller expected certain angles: a digit without markers is ESTIMATED then,
            not LOST.
    """
    covariance = np.empty((len(state.p_m), 21, 21))
    status = np.empty((len(state.p_m), 21), dtype=np.uint8)
    for first in range(0, len(state.p_m), _BATCH):
        rows = np.arange(first, min(first + _BATCH, len(state.p_m)))
        covariance[rows], status[rows] = _batch(problem.at(rows), state.at(rows), given=given)
    return covariance, status


def _batch(problem: PoseProblem, state: PoseState, *, given: bool) -> tuple[Float64, UInt8]:
    information, _, _ = problem.linearised(state)
    posterior = np.linalg.inv(information + problem.prior_information(state, limited=False))
    # what the markers alone tell: beside them only the hand at rest, whatever the caller expected
    rest = rest_prior(len(state.p_m))
    alone = replace(problem, prior=rest)
    free = np.linalg.inv(information + alone.prior_information(state, coupled=False, limited=False))
    std = np.sqrt(np.diagonal(free, axis1=1, axis2=2)[:, JOINT_PART])
    fixed = std < np.minimum(MEASURED_STD_RAD, MEASURED_SHARE * rest.std_rad)
    seen = (problem.precision > 0).all(axis=2)
    digit_seen = np.stack([(seen & (problem.model.digit == digit)).any(axis=1) for digit in range(5)], axis=1)
    status = np.where(fixed, int(Status.MEASURED), int(Status.ESTIMATED))
    status = np.where(digit_seen[:, JOINT_DIGIT], status, int(Status.ESTIMATED if given else Status.LOST))
    return np.asarray(posterior[:, JOINT_PART, JOINT_PART], dtype=np.float64), status.astype(np.uint8)
