"""Laws of association."""

from __future__ import annotations

import numpy as np
import pytest

from rehab_app.geometry.detections import lifted
from rehab_app.geometry.pinhole import KINECT
from rehab_app.tracking.association import (
    GATE,
    IMPOSSIBLE,
    NONE,
    Expected,
    best_pairs,
    clear_pairs,
    pair_costs,
)
from rehab_app.tracking.sight import Sight, sight
from rehab_app.tracking.visibility import facing_chance, seen_chance, shown_after, shown_chance
from sessions.records.fields import Float64

SMALL = 1e-6 * np.eye(3)


def seen_at(points_m: Float64, *, depth: bool = True, pixel_std_px: float = 0.5) -> Sight:
    count = len(points_m)
    return sight(
        lifted(
            0,
            KINECT.project(points_m),
            points_m[:, 2] if depth else np.full(count, np.nan),
            KINECT,
            pixel_std_px=np.full(count, pixel_std_px),
            depth_std_m=np.full(count, 0.002),
            similarity=np.ones(count),
        )
    )


def expected_at(points_m: Float64, covariance: Float64 = SMALL, chance: float = 0.9) -> Expected:
    count = len(points_m)
    return Expected(points_m, np.tile(covariance, (count, 1, 1)), np.full(count, chance))


def test_the_cost_is_the_logarithm_of_a_gaussian_up_to_a_constant() -> None:
    place = np.array([[0.05, -0.03, 0.7]])
    covariance = np.diag([4e-6, 1e-6, 9e-6])
    away = place + np.array([[0.0, 0.0, 0.0], [0.002, 0.001, -0.003], [-0.003, 0.0, 0.004]])
    view = seen_at(away)
    cost = pair_costs(expected_at(place, covariance), view)[0]
    left: list[float] = []
    for one in range(3):
        axes = view.axes[one]
        total = axes @ covariance @ axes.T
        total += np.diag(np.append(np.full(2, view.across_rad2[one] * (axes[2] @ place[0]) ** 2), 0.0))
        total[2, 2] += view.range_variance_m2[one]
        off = axes @ (place[0] - away[one])
        left.append(cost[one] - off @ np.linalg.solve(total, off) - np.log(np.linalg.det(total)))
    assert left == pytest.approx([left[0]] * 3, abs=1e-6)


def test_beyond_the_gate_nothing_is_taken() -> None:
    place = np.array([[0.0, 0.0, 0.7]])
    std = np.sqrt(1e-6 + (0.5 * 0.7 / 525.0) ** 2)
    far = place + np.array([np.sqrt(1.05 * GATE) * std, 0.0, 0.0])
    cost = pair_costs(expected_at(place), seen_at(far))
    assert cost[0, 0] == IMPOSSIBLE
    near = place + np.array([np.sqrt(0.95 * GATE) * std, 0.0, 0.0])
    assert pair_costs(expected_at(place), seen_at(near))[0, 0] < IMPOSSIBLE


def test_a_wrong_depth_is_the_sensors_mistake_and_not_another_marker() -> None:
    place = np.array([[0.0, 0.0, 0.7]])
    right = pair_costs(expected_at(place), seen_at(place))[0, 0]
    wrong = pair_costs(expected_at(place), seen_at(place * 1.3))[0, 0]
    none = pair_costs(expected_at(place), seen_at(place, depth=False))[0, 0]
    assert right < none < 0.0
    assert right < wrong < 0.0


@pytest.mark.parametrize("seed", range(5))
def test_pairs_are_one_to_one_and_follow_a_permutation(seed: int) -> None:
    rng = np.random.default_rng(seed)
    cost = rng.uniform(-20.0, 30.0, (12, 15))
    order, refusal = rng.permutation(15), rng.uniform(0.0, 6.0, 12)
    for pairs in (best_pairs, clear_pairs):
        match, permuted = pairs(cost, refusal), pairs(cost[:, order], refusal)
        taken = match[match != NONE]
        assert len(np.unique(taken)) == len(taken)
        assert np.array_equal(np.where(permuted == NONE, NONE, order[permuted]), match)


def test_a_clear_pair_beats_both_rivals_and_refusal() -> None:
    refusal = np.full(2, 5.0)
    cost = np.array([[-9.0, 8.0], [-6.0, -9.0]])
    assert clear_pairs(cost, refusal).tolist() == [NONE, NONE]  # the second marker contests the first one's
    assert best_pairs(cost, refusal).tolist() == [0, 1]
    assert clear_pairs(np.array([[-9.0, 8.0], [8.0, -9.0]]), refusal).tolist() == [0, 1]
    assert clear_pairs(np.array([[4.0, 30.0], [30.0, -9.0]]), refusal).tolist() == [NONE, 1]


def test_a_marker_rather_stays_alone_than_takes_what_costs_more() -> None:
    assert best_pairs(np.array([[3.0]]), np.array([2.0])).tolist() == [NONE]
    assert best_pairs(np.array([[1.0]]), np.array([2.0])).tolist() == [0]


def test_nothing_seen_nothing_matched() -> None:
    assert clear_pairs(np.empty((3, 0)), np.ones(3)).tolist() == [NONE] * 3
    assert best_pairs(np.empty((3, 0)), np.ones(3)).tolist() == [NONE] * 3
    nothing = seen_at(np.empty((0, 3)))
    assert pair_costs(expected_at(np.array([[0.0, 0.0, 0.7]])), nothing).shape == (1, 0)


def test_markers_that_face_away_or_were_hidden_are_less_expected() -> None:
    normals = np.array([[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]])
    facing = facing_chance(normals, np.array([[0.0, 0.0, 0.7]] * 2), np.zeros(3))
    assert facing[0] > 0.99
    assert facing[1] < 0.01
    shown = shown_after(np.ones(2) * 0.8, np.array([0]))
    assert shown[0] == 1.0
    assert shown[1] < 0.3
    assert seen_chance(shown, np.ones(2))[0] > seen_chance(shown, np.ones(2))[1]
    later = shown_chance(shown, 60.0)
    assert later == pytest.approx(np.full(2, 0.8), abs=1e-6)
    halves = shown_chance(shown_chance(shown, 0.1), 0.2)
    assert halves == pytest.approx(shown_chance(shown, 0.3))
