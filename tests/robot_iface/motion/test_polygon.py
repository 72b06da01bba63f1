"""Laws of convex sets in the plane of two joints."""

from __future__ import annotations

import numpy as np
import pytest

from robot_iface.motion.polygon import area, convex_hull, half_planes, inset, nearest, outside, within_box
from robot_iface.types import Hull

SQUARE = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 2.0], [0.0, 2.0]])
SEEDS = range(20)


def cloud(seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return rng.normal(0.0, 0.5, (rng.integers(4, 40), 2))


@pytest.mark.parametrize("seed", SEEDS)
def test_a_hull_holds_its_points_and_is_convex_without_straight_corners(seed: int) -> None:
    points = cloud(seed)
    corners = convex_hull(points)
    assert outside(corners, points).max() < 1e-6
    Hull(("index_mcp_flexion", "index_pip"), corners)  # refuses what is not strictly convex
    assert set(map(tuple, corners)) <= set(map(tuple, points))


@pytest.mark.parametrize("seed", SEEDS)
def test_an_inset_keeps_its_distance_from_every_edge_and_loses_nothing_else(seed: int) -> None:
    corners = convex_hull(cloud(seed))
    smaller = inset(corners, 0.1)
    if len(smaller) == 0:
        pytest.skip("nothing is left of this one")
    assert outside(corners, smaller).max() == pytest.approx(-0.1, abs=2e-6)
    rng = np.random.default_rng(seed)
    tried = rng.uniform(-2.0, 2.0, (4000, 2))
    depth = outside(corners, tried)
    kept = outside(smaller, tried)
    assert bool((kept[depth < -0.1 - 1e-5] < 1e-5).all())
    assert bool((kept[depth > -0.1 + 1e-5] > -1e-5).all())


def test_an_inset_of_a_rectangle_is_the_smaller_rectangle_and_vanishes_at_half_its_width() -> None:
    np.testing.assert_allclose(np.ptp(inset(SQUARE, 0.2), axis=0), [0.6, 1.6], atol=1e-5)
    assert area(inset(SQUARE, 0.2)) == pytest.approx(0.96, abs=1e-4)
    assert len(inset(SQUARE, 0.51)) == 0


@pytest.mark.parametrize("seed", SEEDS)
def test_the_nearest_point_is_inside_and_nearer_than_any_other(seed: int) -> None:
    corners = convex_hull(cloud(seed))
    rng = np.random.default_rng(seed)
    points = rng.uniform(-3.0, 3.0, (50, 2))
    moved = nearest(corners, points)
    assert outside(corners, moved).max() < 1e-9
    shares = rng.dirichlet(np.ones(len(corners)), 500) @ corners
    best = np.linalg.norm(shares[None] - points[:, None], axis=2).min(axis=1)
    assert bool((np.linalg.norm(moved - points, axis=1) <= best + 1e-9).all())
    inside = outside(corners, points) <= 0.0
    np.testing.assert_array_equal(moved[inside], points[inside])


def test_points_on_a_line_have_no_hull() -> None:
    line = np.linspace(0.0, 1.0, 7)[:, None] * np.array([1.0, 2.0])
    assert area(convex_hull(line)) == 0.0
    assert area(convex_hull(np.zeros((4, 2)))) == 0.0


def test_a_box_cuts_a_polygon() -> None:
    cut = within_box(SQUARE, np.array([0.5, -1.0]), np.array([2.0, 1.0]))
    assert area(cut) == pytest.approx(0.5, abs=1e-5)
    assert len(within_box(SQUARE, np.array([3.0, 3.0]), np.array([4.0, 4.0]))) == 0


def test_normals_point_outwards() -> None:
    normals, offsets = half_planes(SQUARE)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0)
    assert bool((normals @ SQUARE.mean(axis=0) < offsets).all())
