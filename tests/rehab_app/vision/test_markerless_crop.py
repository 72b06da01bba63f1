from __future__ import annotations

import cv2
import numpy as np
import pytest

from rehab_app.vision.markerless.crop import Crop, about_landmarks, about_palm, whole_image
from rehab_app.vision.markerless.palm import anchors, merge


def test_what_lies_at_a_place_of_the_crop_lies_at_its_image_pixel() -> None:
    """A smooth picture, so that interpolation does not hide a shift by half a pixel."""
    v, u = np.mgrid[0:240, 0:320]
    image = np.stack([u * 0.7, v * 0.9, np.zeros_like(u)], axis=2).round().astype(np.uint8)
    crop = Crop(np.array([150.0, 110.0]), 120.0, 0.4)
    part = crop.cut(image, 60, outside=cv2.BORDER_REPLICATE)
    rows, columns = np.mgrid[0:60, 0:60]
    share = (np.stack([columns, rows], axis=2) + 0.5) / 60
    pixel = crop.to_image(share)
    # RGB: the third channel of the image comes first
    np.testing.assert_allclose(part[..., 2] * 255, 0.7 * pixel[..., 0], atol=1.1)
    np.testing.assert_allclose(part[..., 1] * 255, 0.9 * pixel[..., 1], atol=1.1)


def test_a_whole_image_lies_in_the_middle_of_its_square() -> None:
    whole = whole_image(480, 640)
    corners = whole.to_image(np.array([[0.0, 0.0], [1.0, 1.0]]))
    np.testing.assert_allclose(corners, [[-0.5, -80.5], [639.5, 559.5]])


@pytest.mark.parametrize("turn", [0.0, 0.7, 2.5, -1.9])
def test_the_crop_turns_and_grows_with_the_hand(turn: float) -> None:
    rng = np.random.default_rng(4)
    hand = rng.uniform(-50, 50, (21, 2))
    hand[0], hand[5], hand[9], hand[13] = (0, 60), (-20, -20), (0, -25), (15, -22)
    c, s = np.cos(turn), np.sin(turn)
    rotation = np.array([[c, -s], [s, c]])
    straight, turned = about_landmarks(hand), about_landmarks(1.7 * hand @ rotation.T + [300, 200])
    assert np.cos(turned.angle_rad - straight.angle_rad) == pytest.approx(np.cos(turn))
    assert turned.side_px == pytest.approx(1.7 * straight.side_px)
    np.testing.assert_allclose(turned.centre_px, 1.7 * rotation @ straight.centre_px + [300, 200])


def test_the_hand_of_a_palm_lies_towards_its_fingers() -> None:
    crop = about_palm(np.array([100.0, 100.0]), 40.0, np.array([80.0, 100.0]), np.array([120.0, 100.0]))
    np.testing.assert_allclose(crop.centre_px, [120.0, 100.0], atol=1e-9)
    np.testing.assert_allclose(crop.to_image(np.array([0.5, 0.0])), [120.0 + 52.0, 100.0], atol=1e-9)


def test_the_anchors_are_those_of_two_grids() -> None:
    places = anchors()
    assert places.shape == (24 * 24 * 2 + 12 * 12 * 6, 2)
    np.testing.assert_allclose(places[[0, 1, 2, 48]] * 192, [[4, 4], [4, 4], [12, 4], [4, 12]])
    np.testing.assert_allclose(places[[1152, 1157, 1158]] * 192, [[8, 8], [8, 8], [24, 8]])


def test_boxes_of_one_palm_become_their_weighted_mean() -> None:
    places = np.zeros((3, 9, 2))
    places[:, 0] = [[0.30, 0.30], [0.34, 0.30], [0.80, 0.80]]
    places[:, 1] = 0.2
    (first, middle), (second, other) = merge(np.array([0.9, 0.6, 0.7]), places)
    assert (first, second) == (0.9, 0.7)
    np.testing.assert_allclose(middle[0], [(0.9 * 0.30 + 0.6 * 0.34) / 1.5, 0.30])
    np.testing.assert_allclose(other[0], [0.8, 0.8])
    assert merge(np.empty(0), np.empty((0, 9, 2))) == []
