from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from rehab_app.hand.bundle import Bundle, ShapePrior
from rehab_app.hand.pose_prior import rest_prior
from rehab_app.hand.pose_problem import PoseProblem, PoseState


@pytest.fixture(name="bundle")
def _bundle(scene: Callable, random_joints: Callable) -> tuple[Bundle, PoseState]:
    rng = np.random.default_rng(1)
    truth = scene("mocap13", "left", random_joints(25, rng), 2)
    prior = ShapePrior.around(truth.subject, truth.protocol)
    precision = np.full(truth.p_camera_m.shape, 1 / 0.001**2)
    problem = PoseProblem(prior.model(np.zeros(len(prior.std))), truth.p_camera_m, precision, rest_prior(25))
    return Bundle(prior, problem, 0.4), PoseState(
        truth.rotation, truth.p_palm_m, truth.joints_rad, np.zeros(25)
    )


def test_eliminating_the_poses_solves_the_whole_system(bundle: tuple[Bundle, PoseState]) -> None:
    whole, state = bundle
    shape = 0.1 * whole.prior.std * np.random.default_rng(3).standard_normal(len(whole.prior.std))
    step, poses = whole.step(shape, state, 0.0)
    problem = whole.with_shape(shape)
    information, downhill, weight = problem.linearised(state)
    own = information + problem.prior_information(state)
    mixed, shapes, pull = whole._shape_parts(problem, shape, state, weight)
    np.testing.assert_allclose(
        np.einsum("npq,nq->np", own, poses) + mixed @ step, downhill, atol=1e-6 * np.abs(downhill).max()
    )
    left = whole.trust * (shapes @ step + np.einsum("npa,np->a", mixed, poses)) + step / whole.prior.std**2
    right = whole.trust * pull - shape / whole.prior.std**2
    np.testing.assert_allclose(left, right, atol=1e-6 * np.abs(right).max())


def test_the_downhill_direction_is_that_of_the_cost(bundle: tuple[Bundle, PoseState]) -> None:
    whole, state = bundle
    shape = np.zeros(len(whole.prior.std))
    shape[:31] = 0.1 * whole.prior.std[:31]
    problem = whole.with_shape(shape)
    _, downhill, weight = problem.linearised(state)
    _, _, pull = whole._shape_parts(problem, shape, state, weight)
    expected = whole.trust * pull - shape / whole.prior.std**2
    for row in range(0, len(shape), 3):
        ahead = np.zeros(len(shape))
        ahead[row] = 1e-6
        slope = (whole.cost(shape + ahead, state) - whole.cost(shape - ahead, state)) / 2e-6
        assert -slope == pytest.approx(expected[row], rel=1e-3, abs=1e-3 * np.abs(expected).max())
    for row in range(28):
        step = np.zeros((25, 28))
        step[:, row] = 1e-7
        slope = (problem.cost(state.moved(step)) - problem.cost(state.moved(-step))) / 2e-7
        np.testing.assert_allclose(-slope, downhill[:, row], atol=2e-3 * np.abs(downhill).max())
