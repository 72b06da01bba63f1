"""From a recording of a hand to that person's hand: bone lengths and marker places."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from rehab_app.hand.bundle import Bundle, ShapePrior
from rehab_app.hand.marker_model import MarkerModel
from rehab_app.hand.pose_prior import rest_prior
from rehab_app.hand.pose_problem import PoseProblem, PoseState
from rehab_app.hand.pose_solver import solve, solve_from_nothing
from rehab_app.hand.protocol import MarkerProtocol
from rehab_app.hand.series import LandmarkSeries
from rehab_app.hand.subject import Subject, average_subject
from sessions.errors import Refused
from sessions.records import Side
from sessions.records.fields import Float64, Int64

_FRAMES = 60  # well-spread frames that the shape is read from
_TRUSTED_FRAMES = 20.0  # as how many independent ones they count
_FEWEST = 5
_ROUNDS = 60
_LENGTHS_M = (0.09, 0.30)  # what a first, rough fit may say of a human hand


def calibrate_subject(observed: LandmarkSeries, protocol: MarkerProtocol, side: Side) -> Subject:
    """Scale a hand to the person and find where the markers sit on it.

    The frames used are the fullest ones, spread over the shapes that the hand takes (farthest first), so a
    movement tells more than a still hand; a still open hand gives size, proportions and offsets to within the
    priors. Nothing is random.

    Args:
        observed: Markers in the protocol's order; frames with gaps may be among them.
        protocol: The markers.
        side: Side of the hand; never inferred.

    Raises:
        Refused: Fewer than 5 frames show half of the markers, or they fit no human hand of this side.
    """
    if observed.names != protocol.names:
        raise Refused(
            "markers", "others than the protocol's", f"those of {protocol.name}", "name the protocol"
        )
    rows = spread_frames(observed)
    if len(rows) < _FEWEST:
        raise Refused(
            "calibration",
            f"{len(rows)} usable frames",
            f"{_FEWEST} or more",
            "show half of the markers for longer",
        )
    p_m = observed.p_camera_m[rows]
    start, state = sized(p_m, protocol, side)
    precision = _precision(p_m, np.full(len(protocol.markers), protocol.noise_m))
    problem = _problem(MarkerModel(start, protocol), p_m, precision)
    bundle = Bundle(ShapePrior.around(start, protocol), problem, trust_in(len(rows)))
    shape, state = minimised(bundle, np.zeros(len(bundle.prior.std)), state)
    fitted = bundle.with_shape(shape)
    state, _ = solve(fitted, state)
    residual_m = float(np.sqrt((fitted.residuals(state) ** 2).sum() / (precision[..., 0] > 0).sum()))
    if not residual_m < 0.02:
        raise Refused(
            "calibration",
            f"{1e3 * residual_m:.0f} mm off the markers",
            "below 20 mm",
            "check side and protocol",
        )
    return replace(fitted.model.subject, residual_m=residual_m)


def trust_in(frames: int) -> float:
    """Factor on the information of some frames about the shape: they are not independent."""
    return min(1.0, _TRUSTED_FRAMES / max(frames, 1))


def spread_frames(observed: LandmarkSeries, most: int = _FRAMES) -> Int64:
    """Rows of the fullest frames whose shapes lie farthest apart, rising.

    A frame's shape is its distances between markers, so that neither place nor turn of the hand counts.
    """
    seen = observed.seen.sum(axis=1)
    usable = np.flatnonzero(seen >= max(3, 0.5 * len(observed.names)))
    full = usable[seen[usable] >= 0.9 * np.max(seen, initial=0)]
    candidates = full if len(full) >= most else usable
    if len(candidates) <= most:
        return candidates
    candidates = candidates[:: max(1, len(candidates) // 1500)]
    p_m = observed.p_camera_m[candidates]
    first, second = np.triu_indices(p_m.shape[1], 1)
    distances = np.linalg.norm(p_m[:, first] - p_m[:, second], axis=2)
    middle = np.nanmedian(distances, axis=0)
    features = np.where(np.isfinite(distances), distances, middle)
    away = np.full(len(candidates), np.inf)
    chosen = [int(np.argmin(np.abs(features - middle).sum(axis=1)))]
    while len(chosen) < most:
        away = np.minimum(away, np.abs(features - features[chosen[-1]]).sum(axis=1))
        chosen.append(int(np.argmax(away)))
    return np.unique(candidates[chosen])


def sized(
    p_m: Float64,
    protocol: MarkerProtocol,
    side: Side,
    precision: Float64 | None = None,
    axes: Float64 | None = None,
) -> tuple[Subject, PoseState]:
    """An average hand of this person's size, posed; markers count as surely as they are placed.

    Args:
        p_m: Markers, shape (N, M, 3), NaN where unseen.
        protocol: The markers.
        side: Side of the hand.
        precision: 1/variance of what was seen, shape (N, M, 3), if not usual; its zeros are not used.
        axes: Axes of that precision, shape (N, M, 3, 3).

    Raises:
        Refused: The markers fit no human hand.
    """
    loose = replace(protocol, size_std=0.15)
    sigma = np.sqrt(protocol.noise_m**2 + (protocol.offset_stds_m**2).mean(axis=1))
    weight = _precision(p_m, sigma)
    if precision is not None:
        weight = np.where(precision > 0, 1.0 / (sigma[:, None] ** 2 + 1.0 / np.maximum(precision, 1e-9)), 0.0)
    average = average_subject(protocol, side)
    posed = PoseProblem(MarkerModel(average, loose), np.nan_to_num(p_m), weight, rest_prior(len(p_m)), axes)
    state = solve_from_nothing(posed)
    length_m = float(0.189 * np.exp(np.median(state.log_size)))
    if not _LENGTHS_M[0] <= length_m <= _LENGTHS_M[1]:
        bound = f"{_LENGTHS_M[0]:g} to {_LENGTHS_M[1]:g} m"
        raise Refused(
            "hand in the recording", f"{length_m:.3g} m long", bound, "check unit, side and protocol"
        )
    length_m = min(max(length_m, 0.12), 0.25)
    subject = average_subject(protocol, side, length_m)
    still = PoseState(state.rotation, state.p_m, state.joints_rad, np.zeros(len(p_m)))
    return subject, solve(replace(posed, model=MarkerModel(subject, protocol)), still)[0]


def _precision(p_m: Float64, sigma_m: Float64) -> Float64:
    return np.where(np.isfinite(p_m), 1.0 / sigma_m[:, None] ** 2, 0.0)


def _problem(model: MarkerModel, p_m: Float64, precision: Float64) -> PoseProblem:
    return PoseProblem(model, np.nan_to_num(p_m), precision, rest_prior(len(p_m)))


def minimised(
    bundle: Bundle, shape: Float64, state: PoseState, rounds: int = _ROUNDS
) -> tuple[Float64, PoseState]:
    """Levenberg-Marquardt on shape and poses together, from a start, for some rounds at most."""
    cost = bundle.cost(shape, state)
    damping = 1e-2
    for _ in range(rounds):
        step, pose_step = bundle.step(shape, state, damping)
        trial, trial_state = shape + step, state.moved(pose_step)
        trial_cost = bundle.cost(trial, trial_state)
        if trial_cost < cost:
            gain, shape, state, cost = cost - trial_cost, trial, trial_state, trial_cost
            damping = max(0.2 * damping, 1e-7)
            if gain < 1e-4 * cost:
                break
        else:
            damping *= 8.0
            if damping > 1e6:
                break
    return shape, state
