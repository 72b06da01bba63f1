"""Laws of association."""

from __future__ import annotations

import numpy as np
import pytest

from rehab_app.tracking.association import NONE, best_pairs, clear_pairs, distances, facing_penalty

UNIT = np.eye(3)


def test_distance_is_mahalanobis_beside_the_volume() -> None:
    covariance = np.diag([4.0, 1.0, 1.0])
    cost = distances(np.zeros((1, 3)), covariance[None], np.array([[2.0, 0.0, 0.0]]), np.zeros((1, 3, 3)))
    assert cost[0, 0] == pytest.approx(1.0)  # the volume is that of the only pair, so it adds nothing


def test_beyond_the_gate_nothing_is_taken() -> None:
    cost = distances(np.zeros((1, 3)), UNIT[None], np.array([[4.1, 0.0, 0.0]]), np.zeros((1, 3, 3)))
    assert best_pairs(cost).tolist() == [NONE]
    assert clear_pairs(cost).tolist() == [NONE]


@pytest.mark.parametrize("seed", range(5))
def test_pairs_are_one_to_one_and_follow_a_permutation(seed: int) -> None:
    rng = np.random.default_rng(seed)
    cost = rng.uniform(0.0, 30.0, (12, 15))
    order = rng.permutation(15)
    for pairs in (best_pairs, clear_pairs):
        match, permuted = pairs(cost), pairs(cost[:, order])
        taken = match[match != NONE]
        assert len(np.unique(taken)) == len(taken)
        assert np.array_equal(np.where(permuted == NONE, NONE, order[permuted]), match)


def test_a_clear_pair_beats_both_rivals() -> None:
    cost = np.array([[1.0, 20.0], [4.0, 1.0]])
    assert clear_pairs(cost).tolist() == [NONE, NONE]  # the second marker contests the first one's
    assert best_pairs(cost).tolist() == [0, 1]
    assert clear_pairs(np.array([[1.0, 20.0], [20.0, 1.0]])).tolist() == [0, 1]


def test_nothing_seen_nothing_matched() -> None:
    assert clear_pairs(np.empty((3, 0))).tolist() == [NONE] * 3
    assert best_pairs(np.empty((3, 0))).tolist() == [NONE] * 3


def test_markers_that_face_away_cost_more() -> None:
    normals = np.array([[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]])
    penalty = facing_penalty(normals, np.array([[0.0, 0.0, 0.7]] * 2))
    assert penalty[0] == 0.0
    assert penalty[1] > 0.0
