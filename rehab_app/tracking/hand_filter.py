"""One capture into the hand's state: an iterated, robust Kalman update with soft anatomy.

The unknowns are the 27 positions; rates follow through their covariance with them. Each pair of marker and
detection brings two rows across its ray and, where there is depth, one along it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from rehab_app.hand.marker_model import MarkerModel
from rehab_app.hand.pose_prior import LIMIT_STD_RAD, beyond_limits, coupling_precision, rest_prior
from rehab_app.hand.pose_problem import PoseState, marker_slopes, placed_arms
from rehab_app.tracking.hand_state import JOINT_ROWS, POSITIONS, HandState
from rehab_app.tracking.sight import Sight
from sessions.records.fields import Float64, Int64

Bool = NDArray[np.bool_]

_ITERATIONS = 4
_SETTLED = 2e-3  # step, rad and m, after which the next would be far smaller
_HUBER = 2.5
WRONG_DEPTH_M = 0.020
"""Farther than this from where the hand is, beyond its spread, a depth is not used."""

_REST = rest_prior(1)
_REST_S = 2.0  # the rest prior counts once in this time: an unseen joint leans to it, a seen one hardly
_COUPLED_S = 0.15
_COUPLING = coupling_precision()


@dataclass(frozen=True, slots=True)
class Pairs:
    """Markers and the detections given to them.

    Attributes:
        marker: Index of the marker of each pair, shape (K,).
        row: Row of its detection, shape (K,).
        extra_m2: Variance beyond the sensor's across the ray, for blobs that may be merged, shape (K,).
        insisted: Whether the marker's depths have for some captures been far from the hand, but alike: then
            it is the hand that is wrong, shape (K,).
    """

    marker: Int64
    row: Int64
    extra_m2: Float64
    insisted: Bool

    def __len__(self) -> int:
        """Number of pairs."""
        return len(self.marker)


def plain_pairs(marker: Int64, row: Int64) -> Pairs:
    """Pairs of which nothing special is known."""
    return Pairs(marker, row, np.zeros(len(marker)), np.zeros(len(marker), dtype=np.bool_))


NO_PAIRS = plain_pairs(np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64))
"""Nothing was given to any marker."""


@dataclass(frozen=True, slots=True)
class Placed:
    """Markers of a state in the camera frame.

    Attributes:
        p_m: Places, shape (M, 3).
        slopes: Derivative in the 27 positions, shape (M, 3, 27).
        normals: Unit vectors out of the back of each marker's segment, shape (M, 3).
        landmarks_m: The 25 landmarks, shape (25, 3).
    """

    p_m: Float64
    slopes: Float64
    normals: Float64
    landmarks_m: Float64

    def covariance_m2(self, positions: Float64) -> Float64:
        """Covariance of the markers from that of the positions (27, 27), shape (M, 3, 3)."""
        return self.slopes @ positions @ np.swapaxes(self.slopes, 1, 2)


@dataclass(frozen=True, slots=True)
class Rows:
    """Residuals of pairs in their rays' axes.

    Attributes:
        residual_m: Seen minus expected, two across and one along the ray (0 without depth), shape (K, 3).
        variance_m2: Variance of each; infinite where it is not used, shape (K, 3).
        slopes: Derivative of the expected, shape (K, 3, 27).
        insisted: See ``Pairs``.
    """

    residual_m: Float64
    variance_m2: Float64
    slopes: Float64
    insisted: Bool


def placed(model: MarkerModel, state: HandState) -> Placed:
    """The markers of a state."""
    pose = PoseState(state.rotation[None], state.p_m[None], state.joints_rad[None], np.zeros(1))
    markers, arms = placed_arms(model, pose)
    slopes = marker_slopes(model, pose, markers, arms)[0, ..., :POSITIONS]
    back = -markers.segments[0][..., 0][model.segments] * model.mirror
    landmarks = markers.frames.landmarks_m[0] * model.mirror
    return Placed(
        arms[0] + state.p_m, slopes, back @ state.rotation.T, landmarks @ state.rotation.T + state.p_m
    )


def rows_of(markers: Placed, sight: Sight, pairs: Pairs, wobble_m2: float) -> Rows:
    """Residuals, their variances and derivatives."""
    local = sight.local(markers.p_m[pairs.marker], pairs.row)
    slopes = sight.axes[pairs.row] @ markers.slopes[pairs.marker]
    residual, variance = -local, np.empty_like(local)
    variance[:, :2] = (sight.across_rad2[pairs.row] * local[:, 2] ** 2 + wobble_m2 + pairs.extra_m2)[:, None]
    known = np.isfinite(sight.range_m[pairs.row])
    residual[:, 2] = np.where(known, sight.range_m[pairs.row] - local[:, 2], 0.0)
    variance[:, 2] = np.where(known, sight.range_variance_m2[pairs.row] + wobble_m2, np.inf)
    return Rows(residual, variance, slopes, pairs.insisted)


def trusted(rows: Rows) -> Bool:
    """Which rows agree with the hand as it was fitted: depths that are far off do not, shape (K, 3)."""
    result = np.isfinite(rows.variance_m2)
    result[:, 2] &= (np.abs(rows.residual_m[:, 2]) <= WRONG_DEPTH_M) | rows.insisted
    return result


@dataclass(frozen=True, slots=True)
class Estimate:
    """A hand under way from the prediction to what a capture says.

    Attributes:
        state: The hand.
        moved: By how much its positions were moved from the prediction, shape (27,).
        placed: Its markers.
    """

    state: HandState
    moved: Float64
    placed: Placed


def unmoved(model: MarkerModel, prior: HandState) -> Estimate:
    """The prediction itself."""
    return Estimate(prior, np.zeros(POSITIONS), placed(model, prior))


def updated(
    model: MarkerModel,
    prior: HandState,
    sight: Sight,
    pairs: Pairs,
    wobble_m2: float,
    span_s: float,
    start: Estimate | None = None,
) -> Estimate:
    """The hand after a capture.

    Args:
        model: The person with the markers.
        prior: The hand as predicted for this capture.
        sight: What was seen.
        pairs: Which detections are which markers.
        wobble_m2: Variance of a marker's place on its bone, per axis.
        span_s: Time since the last capture: weak knowledge counts by the second, not by the frame.
        start: Where to begin, if nearer than the prediction.
    """
    information: Float64 = _inverse(prior.position_covariance)
    now = start or unmoved(model, prior)
    state, moved, markers, total = now.state, now.moved, now.placed, information
    for _ in range(_ITERATIONS):
        rows = rows_of(markers, sight, pairs, wobble_m2)
        weight = _weights(rows, None if moved.any() else prior.position_covariance)
        flat = rows.slopes.reshape(-1, POSITIONS)
        scaled = (rows.slopes * weight[..., None]).reshape(-1, POSITIONS)
        anatomy, pull = _anatomy(state.joints_rad, span_s)
        total = information + scaled.T @ flat
        total[JOINT_ROWS, JOINT_ROWS] += anatomy
        slope = scaled.T @ rows.residual_m.ravel() - information @ moved
        slope[JOINT_ROWS] += pull
        step: Float64 = np.asarray(np.linalg.solve(total, slope), dtype=np.float64)
        state, moved = state.moved(step), moved + step
        markers = placed(model, state)
        if float(np.abs(step).max()) < _SETTLED:
            break
    return Estimate(_concluded(prior, state, moved, information, _inverse(total)), moved, markers)


def _inverse(matrix: Float64) -> Float64:
    return np.asarray(np.linalg.inv(matrix), dtype=np.float64)


def _weights(rows: Rows, positions: Float64 | None) -> Float64:
    """1/variance of every row, less where it disagrees; shape (K, 3).

    Args:
        rows: Residuals.
        positions: Covariance of the positions before the first step, when residuals are innovations; None
            later, when they are what is left over.
    """
    variance = rows.variance_m2
    spread = variance
    if positions is not None:
        spread = variance + np.einsum("kai,ij,kaj->ka", rows.slopes, positions, rows.slopes)
    apart = np.abs(rows.residual_m) / np.sqrt(spread)
    across = np.hypot(apart[:, 0], apart[:, 1])
    weight = np.empty_like(variance)
    weight[:, :2] = (_HUBER / np.maximum(across, _HUBER))[:, None]
    wild = np.abs(rows.residual_m[:, 2]) > WRONG_DEPTH_M + 2.0 * np.sqrt(np.minimum(spread[:, 2], 1.0))
    weight[:, 2] = np.where(wild & ~rows.insisted, 0.0, _HUBER / np.maximum(apart[:, 2], _HUBER))
    return weight / variance


def _anatomy(joints_rad: Float64, span_s: float) -> tuple[Float64, Float64]:
    """Information (21, 21) and pull (21,) of limits, coupling and rest."""
    out = beyond_limits(joints_rad)
    rest = min(span_s / _REST_S, 1.0) / _REST.std_rad**2
    coupling = min(span_s / _COUPLED_S, 1.0) * _COUPLING
    information = coupling + np.diag(rest + (out != 0.0) / LIMIT_STD_RAD**2)
    pull = -coupling @ joints_rad - out / LIMIT_STD_RAD**2 - rest * (joints_rad - _REST.joints_rad[0])
    return information, pull


def _concluded(
    prior: HandState, state: HandState, moved: Float64, information: Float64, posterior: Float64
) -> HandState:
    """Rates and the whole covariance after the positions were corrected by ``moved``."""
    size = POSITIONS
    gain = prior.covariance[size:, :size] @ information
    covariance = np.empty_like(prior.covariance)
    covariance[:size, :size] = posterior
    covariance[size:, :size] = gain @ posterior
    covariance[:size, size:] = covariance[size:, :size].T
    change = posterior - prior.position_covariance
    covariance[size:, size:] = prior.covariance[size:, size:] + gain @ change @ gain.T
    covariance = 0.5 * (covariance + covariance.T)
    return replace(state, rate=prior.rate + gain @ moved, covariance=covariance)
