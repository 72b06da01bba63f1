"""Stone Soup's global nearest neighbour and joint probabilistic data association as peers, in the image."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta
from typing import Any

import numpy as np
from stonesoup.dataassociator.neighbour import GNNWith2DAssignment
from stonesoup.dataassociator.probability import JPDAwithLBP
from stonesoup.functions import gm_reduce_single
from stonesoup.hypothesiser.distance import DistanceHypothesiser
from stonesoup.hypothesiser.probability import PDAHypothesiser
from stonesoup.measures import Mahalanobis
from stonesoup.models.measurement.linear import LinearGaussian
from stonesoup.models.transition.linear import CombinedLinearGaussianTransitionModel, ConstantVelocity
from stonesoup.predictor.kalman import KalmanPredictor
from stonesoup.types.detection import Detection
from stonesoup.types.state import GaussianState
from stonesoup.types.track import Track
from stonesoup.types.update import GaussianStateUpdate
from stonesoup.updater.kalman import KalmanUpdater

from rehab_app.cameras.sequence import PointSequence
from sessions.records.fields import Float64
from tests.bench.tracking.score import Tracks

_ACCELERATION_PX2_S3 = 2.0e4  # spectral density: about 0.9 px of drift per frame at 30 Hz
_NOISE_PX = 1.0
_SPEED_STD_PX_S = 60.0
_START = datetime(2026, 1, 1, tzinfo=UTC)


def stone_soup_gnn(sequence: PointSequence) -> Tracks:
    """Global nearest neighbour with Kalman filters."""
    predictor, updater = _filters()
    hypothesiser = DistanceHypothesiser(predictor, updater, Mahalanobis(), missed_distance=4.0)
    return _follow(sequence, GNNWith2DAssignment(hypothesiser), updater)


def stone_soup_jpda(sequence: PointSequence) -> Tracks:
    """Joint probabilistic data association with Kalman filters.

    By loopy belief propagation: enumeration of the hypotheses of 25 near markers does not end.
    """
    predictor, updater = _filters()
    area = sequence.intrinsics.width_px * sequence.intrinsics.height_px
    density = max(sequence.level.clutter + sequence.level.persistent, 0.3) / area
    hypothesiser = PDAHypothesiser(
        predictor, updater, clutter_spatial_density=density, prob_detect=0.9, prob_gate=0.999
    )
    return _follow(sequence, JPDAwithLBP(hypothesiser), updater)


def _filters() -> tuple[Any, Any]:
    move = CombinedLinearGaussianTransitionModel([ConstantVelocity(_ACCELERATION_PX2_S3)] * 2)
    see = LinearGaussian(4, (0, 2), _NOISE_PX**2 * np.eye(2))
    return KalmanPredictor(move), KalmanUpdater(see)


def _follow(sequence: PointSequence, associator: Any, updater: Any) -> Tracks:
    """One track per marker from the labels of frame 0, neither born nor ended later."""
    frames, markers = sequence.visible.shape
    said = np.full((frames, markers, 2), np.nan)
    detection = np.full((frames, markers), -1, dtype=np.int64)
    tracks = [_track(pixel) for pixel in sequence.init_pixel_px]
    for frame, one in sequence.received():
        now = _START + timedelta(microseconds=int(sequence.t_ns[frame]) // 1000 + 1)
        seen = [Detection(pixel.reshape(2, 1), timestamp=now) for pixel in one.pixel_px]
        rows = {id(shot): row for row, shot in enumerate(seen)}
        for track, found in associator.associate(set(tracks), set(seen), now).items():
            marker = tracks.index(track)
            state, best = _updated(found, updater)
            track.append(state)
            said[frame, marker] = np.asarray(state.state_vector, np.float64).ravel()[[0, 2]]
            detection[frame, marker] = rows.get(best, -1)
    return Tracks(said, detection)


def _track(pixel_px: Float64) -> Any:
    spread = np.diag([_NOISE_PX**2, _SPEED_STD_PX_S**2] * 2)
    return Track([GaussianState([pixel_px[0], 0.0, pixel_px[1], 0.0], spread, timestamp=_START)])


def _updated(found: Any, updater: Any) -> tuple[Any, int]:
    """State after one frame and the id of the detection that it owes most to (0 for none)."""
    if not hasattr(found, "__iter__"):
        if not found:
            return found.prediction, 0
        return updater.update(found), id(found.measurement)
    weights = np.array([float(one.probability) for one in found])
    states = [updater.update(one) if one else one.prediction for one in found]
    mean, covariance = gm_reduce_single(
        np.hstack([np.asarray(state.state_vector, np.float64) for state in states]),
        np.stack([np.asarray(state.covar, np.float64) for state in states], axis=2),
        weights / weights.sum(),
    )
    best = found[int(weights.argmax())]
    state = GaussianStateUpdate(mean, covariance, timestamp=best.prediction.timestamp, hypothesis=found)
    return state, id(best.measurement) if best else 0
