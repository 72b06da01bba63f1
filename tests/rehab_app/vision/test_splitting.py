"""Merged markers come apart; single ones stay whole."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from rehab_app.geometry.pinhole import KINECT
from rehab_app.vision import ContrastDetector
from rehab_app.vision.contrast import Image
from sessions.records.fields import Float64

SKIN, WHITE, BLUE = (118, 152, 205), (238, 238, 238), (196, 92, 34)
SCALE = 8


def picture(ellipses: list[tuple[float, float, float, float]], radius: float = 4.7) -> Image:
    """Discs (u, v, flatness, turn in degrees) in their rings on skin, later ones over earlier ones."""
    big = np.full((480 * SCALE // 4, 640 * SCALE // 4, 3), SKIN, np.uint8)  # a quarter of the picture
    for u, v, flat, turn in ellipses:
        centre = (round((u + 0.5) * SCALE), round((v + 0.5) * SCALE))
        for size, ink in ((radius * 8 / 6, WHITE), (radius, BLUE)):
            axes = (round(size * SCALE), round(size * flat * SCALE))
            cv2.ellipse(big, centre, axes, turn, 0, 360, ink, -1)
    part = np.asarray(cv2.resize(big, (160, 120), interpolation=cv2.INTER_AREA), np.uint8)
    whole = np.full((480, 640, 3), SKIN, np.uint8)
    whole[200:320, 240:400] = part
    return whole


def centres(image: Image, step: tuple[int, float] | None = None) -> Float64:
    depth = np.full((480, 640), 0.67, np.float32)
    if step is not None:
        depth[200 + step[0] :] = step[1]
    seen = ContrastDetector().detect(0, image, depth, KINECT)
    order = np.argsort(seen.pixel_px[:, 1])
    return seen.pixel_px[order] - np.array([240.0, 200.0])


@pytest.mark.parametrize("gap", [5.6, 6.5, 8.0])
def test_flat_neighbours_on_a_curled_finger_come_apart(gap: float) -> None:
    found = centres(picture([(80, 60, 0.45, 0), (80, 60 + gap, 0.45, 0)]))
    assert len(found) == 2
    assert found == pytest.approx(np.array([[80, 60], [80, 60 + gap]]), abs=0.8)


@pytest.mark.parametrize("flat", [0.3, 0.5, 0.8, 1.0])
@pytest.mark.parametrize("turn", [0.0, 35.0, 90.0])
def test_a_single_disc_stays_whole(flat: float, turn: float) -> None:
    found = centres(picture([(80.3, 60.4, flat, turn)]))
    assert len(found) == 1
    assert found[0] == pytest.approx([80.3, 60.4], abs=0.15)


def test_bare_discs_that_touch_are_parted_by_their_length() -> None:
    image = picture([(80, 50, 1.0, 0), (80, 58.2, 1.0, 0)])
    bridge = np.s_[200 + 52 : 200 + 56, 240 + 78 : 240 + 83]
    image[bridge] = BLUE
    assert len(centres(image)) == 2
