"""The Kalman filter over stacks against filterpy's, one state at a time."""

from __future__ import annotations

import numpy as np
import pytest
from filterpy.kalman import KalmanFilter
from scipy.stats import multivariate_normal

from rehab_app.tracking.kalman import (
    LinearModel,
    corrected,
    innovation_covariance,
    log_density,
    plane_terms,
    predicted,
)
from rehab_app.tracking.rbmcda_particles import image_model
from rehab_app.tracking.rbmcda_settings import RbmcdaSettings
from sessions.records.fields import Float64


def random_model(rng: np.random.Generator, n: int, m: int) -> LinearModel:
    process, noise = rng.normal(size=(n, n)), rng.normal(size=(m, m))
    return LinearModel(
        rng.normal(size=(n, n)), process @ process.T, rng.normal(size=(m, n)), noise @ noise.T + np.eye(m)
    )


def reference(model: LinearModel, mean: Float64, covariance: Float64) -> KalmanFilter:
    kf = KalmanFilter(dim_x=len(mean), dim_z=len(model.measurement))
    kf.F, kf.Q, kf.H, kf.R = model.transition, model.process, model.measurement, model.noise
    kf.x, kf.P = mean.copy(), covariance.copy()
    return kf


@pytest.mark.parametrize(("n", "m", "seed"), [(2, 2, 0), (4, 2, 1), (6, 3, 2)])
def test_a_stack_of_filters_equals_filterpy_one_by_one(n: int, m: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    model = random_model(rng, n, m)
    mean, root = rng.normal(size=(3, 5, n)), rng.normal(size=(3, 5, n, n))
    covariance = root @ np.swapaxes(root, -1, -2) + np.eye(n)
    ones = [[reference(model, mean[i, j], covariance[i, j]) for j in range(5)] for i in range(3)]
    for _ in range(4):
        measured = rng.normal(size=(3, 5, m))
        mean, covariance = predicted(mean, covariance, model)
        spread = innovation_covariance(covariance, model)
        mean, covariance = corrected(mean, covariance, measured, model)
        for i in range(3):
            for j in range(5):
                kf = ones[i][j]
                kf.predict()
                kf.update(measured[i, j])
                assert mean[i, j] == pytest.approx(kf.x, abs=1e-9, rel=1e-9)
                assert covariance[i, j] == pytest.approx(kf.P, abs=1e-9, rel=1e-9)
                assert spread[i, j] == pytest.approx(kf.S, abs=1e-9, rel=1e-9)


def test_covariances_stay_symmetric_and_positive() -> None:
    rng = np.random.default_rng(3)
    model = image_model(RbmcdaSettings(motion="damped_velocity"), 1.0)
    mean, covariance = np.zeros((7, 4)), np.tile(1e4 * np.eye(4), (7, 1, 1))
    for _ in range(300):
        mean, covariance = predicted(mean, covariance, model)
        mean, covariance = corrected(mean, covariance, rng.normal(size=(7, 2)), model)
    assert np.array_equal(covariance, np.swapaxes(covariance, -1, -2))
    assert (np.linalg.eigvalsh(covariance) > 0).all()


def test_the_density_is_that_of_the_plane_normal() -> None:
    rng = np.random.default_rng(4)
    root = rng.normal(size=(6, 2, 2))
    covariance = root @ np.swapaxes(root, -1, -2) + 0.1 * np.eye(2)
    surprise = rng.normal(size=(6, 2))
    known = [multivariate_normal([0, 0], s).logpdf(v) for s, v in zip(covariance, surprise, strict=True)]
    assert log_density(surprise, plane_terms(covariance)) == pytest.approx(known, abs=1e-12, rel=1e-12)


def test_a_long_gap_moves_a_damped_marker_as_far_as_so_many_periods() -> None:
    settings = RbmcdaSettings(motion="damped_velocity")
    one, many = image_model(settings, 1.0), image_model(settings, 12.0)
    assert np.linalg.matrix_power(one.transition, 12) == pytest.approx(many.transition)
    # undamped it would be 12 px per px of speed; damped it never runs farther than 1 / (1 - damping)
    assert many.transition[0, 2] < 1.0 / (1.0 - settings.damping)


def test_an_undamped_speed_lasts() -> None:
    model = image_model(RbmcdaSettings(motion="damped_velocity", damping=1.0), 3.0)
    assert model.transition[0].tolist() == [1.0, 0.0, 3.0, 0.0]
