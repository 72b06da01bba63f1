from __future__ import annotations

import numpy as np

from rehab_app.geometry.pinhole import KINECT
from rehab_app.vision.look import window_about, within_reach


def test_what_is_far_before_behind_or_beside_the_hand_is_out_of_reach() -> None:
    hand = np.random.default_rng(0).normal([0.0, 0.0, 0.7], 0.03, (12, 3))
    others = np.array([[0.0, 0.0, 1.0], [0.0, 0.0, 0.45], [0.3, 0.0, 0.7], [0.0, -0.3, 0.7]])
    near = within_reach(np.concatenate([hand, others]), np.ones(16), 0.16, 0.2)
    assert near.tolist() == [True] * 12 + [False] * 4


def test_the_weightier_cluster_is_the_hand() -> None:
    rng = np.random.default_rng(1)
    points = np.concatenate([rng.normal([0.0, 0.0, z], 0.02, (9, 3)) for z in (0.7, 1.4)])
    weight = np.repeat([0.9, 0.4], 9)
    assert within_reach(points, weight, 0.16, 0.2).tolist() == [True] * 9 + [False] * 9


def test_nothing_is_in_reach_of_nothing() -> None:
    points = np.array([[0.0, 0.0, 0.7], [np.nan, np.nan, np.nan]])
    assert not within_reach(points, np.array([0.0, 1.0]), 0.16, 0.2).any()
    assert within_reach(np.zeros((0, 3)), np.zeros(0), 0.16, 0.2).shape == (0,)


def test_the_window_holds_the_points_with_a_margin_and_stays_in_the_picture() -> None:
    points = np.array([[-0.05, -0.05, 0.7], [0.05, 0.05, 0.7]])
    top, left, bottom, right = window_about(points, KINECT)
    pixel = KINECT.project(points)
    assert left < pixel[0, 0] - 40
    assert top < pixel[0, 1] - 40
    assert right > pixel[1, 0] + 40
    assert bottom > pixel[1, 1] + 40
    assert window_about(points + np.array([5.0, 0.0, 0.0]), KINECT) == (0, 0, 480, 640)
    assert window_about(None, KINECT) == (0, 0, 480, 640)
