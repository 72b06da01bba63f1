"""The robot hand's chains against laws: straight length, planar geometry, inverse undoes forward."""

from __future__ import annotations

import numpy as np
import pytest

from robot_iface.errors import Refused
from robot_iface.kinematics.dlr_hit import (
    FINGER_MAX_RAD,
    FINGER_MIN_RAD,
    LINKS_M,
    aperture_rad,
    dlr_hit_hand,
    finger_frames,
    finger_inverse,
    finger_points,
    hand_points,
)


def test_the_straight_finger_is_105_mm_long() -> None:
    assert finger_points(np.zeros(3))[-1] == pytest.approx([0.105, 0.0, 0.0], abs=1e-15)


def test_the_chain_is_the_planar_one_turned_by_the_abduction() -> None:
    q = np.random.default_rng(2).uniform(FINGER_MIN_RAD, FINGER_MAX_RAD, (500, 3))
    flexion = q[:, 1:2] + q[:, 2:3] * np.array([0, 1, 2])
    steps = np.array(LINKS_M)
    along = np.cumsum(steps * np.cos(flexion), axis=1)
    down = np.cumsum(steps * np.sin(flexion), axis=1)
    expected = np.stack([along * np.cos(q[:, :1]), along * np.sin(q[:, :1]), -down], axis=-1)
    assert np.abs(finger_points(q)[:, 1:] - expected).max() < 1e-15
    rotation = finger_frames(q)[..., :3, :3]
    assert np.abs(rotation @ np.swapaxes(rotation, -1, -2) - np.eye(3)).max() < 1e-14


def test_the_inverse_undoes_the_forward() -> None:
    q = np.random.default_rng(3).uniform(FINGER_MIN_RAD, FINGER_MAX_RAD, (2000, 3))
    tips = finger_points(q)[:, 3]
    found = finger_inverse(tips)
    assert np.abs(finger_points(found)[:, 3] - tips).max() < 1e-9
    bent = q[:, 2] > np.deg2rad(5)
    assert np.abs(found - q)[bent].max() < 1e-7
    rho = np.linalg.norm(tips, axis=1)
    a, b, c = LINKS_M
    k = np.cos(q[:, 2])
    assert rho**2 == pytest.approx(
        a * a + b * b + c * c - 2 * a * c + 2 * b * (a + c) * k + 4 * a * c * k * k
    )


def test_what_no_finger_can_reach_is_refused_with_its_bound() -> None:
    for point, word in (
        ([0.2, 0, 0], "0.105 m"),
        ([np.nan, 0, 0], "not finite"),
        ([0.05, 0.08, 0], "abduction"),
        ([0.05, 0.0, 0.06], "MCP"),
        ([0.0, 0.0, -0.001], "m"),
    ):
        with pytest.raises(Refused, match=word):
            finger_inverse(np.array(point, dtype=np.float64))


def test_the_hand_stands_as_the_thesis_says() -> None:
    hand = dlr_hit_hand()
    assert np.linalg.norm(hand.bases_m[1:], axis=1) == pytest.approx([0.117, 0.1183, 0.117, 0.105])
    x, y, z = hand.bases_m[0]
    assert np.rad2deg(np.arctan2(y, x)) == pytest.approx(35.51, abs=0.01)
    assert np.rad2deg(np.arccos(z / np.linalg.norm(hand.bases_m[0]))) == pytest.approx(44.13, abs=0.01)
    assert np.rad2deg(aperture_rad(hand)) == pytest.approx(37.14, abs=0.02)
    assert np.linalg.det(hand.base_rotation) == pytest.approx(1.0)


def test_flexion_goes_to_palmar_and_abduction_to_radial() -> None:
    hand = dlr_hit_hand()
    straight = hand_points(hand, np.zeros((5, 3)))
    bent = hand_points(hand, np.tile([0.0, 0.5, 0.5], (5, 1)))
    spread = hand_points(hand, np.tile([0.2, 0.0, 0.0], (5, 1)))
    assert (bent[1:, 3, 0] > straight[1:, 3, 0]).all()
    assert (spread[1:, 3, 1] > straight[1:, 3, 1]).all()
