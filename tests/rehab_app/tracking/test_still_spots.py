"""What stands still in the image, through misses, flicker and bad depth."""

from __future__ import annotations

import numpy as np
import pytest

from rehab_app.geometry.detections import Detections, lifted
from rehab_app.geometry.pinhole import KINECT
from rehab_app.tracking.still_spots import NONE, nearest_in_image, still_spots
from sessions.records.fields import Float64

PLACES_M = np.array([[0.0, 0.0, 0.7], [0.05, 0.0, 0.71], [0.0, 0.05, 0.69], [-0.05, 0.01, 0.7]])


def seen(points_m: Float64, depth_m: Float64 | None = None) -> Detections:
    count = len(points_m)
    return lifted(
        0,
        KINECT.project(points_m),
        points_m[:, 2] if depth_m is None else depth_m,
        KINECT,
        pixel_std_px=np.ones(count),
        depth_std_m=np.full(count, 0.002),
        similarity=np.ones(count),
    )


def sorted_rows(points_m: Float64) -> Float64:
    return points_m[np.lexsort(points_m[:, :2].T)]


def test_misses_flicker_and_bad_depths_move_nothing() -> None:
    rng = np.random.default_rng(0)
    captures: list[Detections] = []
    for miss in range(4):
        points = np.vstack(
            [np.delete(PLACES_M, miss, axis=0), rng.uniform([-0.2, -0.2, 0.5], [0.2, 0.2, 0.9], (1, 3))]
        )
        depth = points[:, 2].copy()
        depth[0] = np.nan if miss % 2 else depth[0]
        captures.append(seen(points, depth))
    bad = PLACES_M[:, 2] + [0.15, 0.0, 0.0, 0.0]
    captures += [seen(PLACES_M), seen(PLACES_M, bad)]
    assert sorted_rows(still_spots(captures, 0.6)) == pytest.approx(sorted_rows(PLACES_M), abs=1e-9)


def test_a_blob_that_never_has_depth_lies_at_the_range_of_the_others() -> None:
    depth = PLACES_M[:, 2].copy()
    depth[0] = np.nan
    spots = still_spots([seen(PLACES_M, depth)] * 3, 0.5)
    assert len(spots) == 4
    nearest = spots[np.linalg.norm(spots[:, :2], axis=1).argmin()]
    assert nearest == pytest.approx([0.0, 0.0, 0.7], abs=1e-9)


def test_what_moves_is_no_spot_and_nothing_gives_nothing() -> None:
    moving = [seen(PLACES_M + 0.02 * step * np.eye(3)[0]) for step in range(2)]
    assert len(still_spots(moving, 1.0)) == 0
    assert still_spots([seen(np.empty((0, 3)))], 0.5).shape == (0, 3)


def test_each_spot_gets_the_blob_next_to_it_and_no_blob_serves_two() -> None:
    spots = np.vstack([PLACES_M[:2], [[np.nan] * 3], PLACES_M[0] + [0.004, 0.0, 0.0]])
    match = nearest_in_image(spots, seen(PLACES_M[[1, 0]]), 0.012)
    assert match.tolist() == [1, 0, NONE, NONE]
    assert nearest_in_image(spots, seen(np.empty((0, 3))), 0.012).tolist() == [NONE] * 4
