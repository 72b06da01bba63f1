from __future__ import annotations

import numpy as np
import pytest

from rehab_app.cameras import virtual_camera
from rehab_app.hand.protocol import load_protocol
from rehab_app.vision.contrast import Image
from rehab_app.vision.exposure import PictureWatch, picture_fault

CAMERA = virtual_camera("open_close", "right", 6.0, load_protocol("thesis25"), seed=2)
FRAME = CAMERA.frame(3)


def scaled(gain: float) -> Image:
    return np.clip(FRAME.colour_bgr * gain, 0, 255).astype(np.uint8)


def test_a_good_picture_has_no_fault() -> None:
    assert picture_fault(FRAME.colour_bgr, FRAME.depth_m) is None
    assert picture_fault(FRAME.colour_bgr, None) is None


@pytest.mark.parametrize("level", ["easy", "hard", "extreme"])
def test_hard_pictures_are_no_faults(level: str) -> None:
    camera = virtual_camera("mixed", "left", 6.0, load_protocol("thesis25"), seed=5, level=level)
    for index in (0, 40, 80):
        frame = camera.frame(index)
        assert picture_fault(frame.colour_bgr, frame.depth_m) is None


@pytest.mark.parametrize(
    ("colour", "word"),
    [
        (np.zeros((480, 640, 3), np.uint8), "black"),
        (scaled(0.04), "black"),
        (scaled(0.2), "too dark"),
        (scaled(2.5), "over-exposed"),
        (np.full((480, 640, 3), 255, np.uint8), "over-exposed"),
        (np.full((480, 640, 3), 120, np.uint8), "one even tone"),
        (FRAME.colour_bgr[..., 1:2].repeat(3, axis=2), "no colour"),
    ],
)
def test_each_fault_is_one_sentence_with_a_remedy(colour: Image, word: str) -> None:
    said = picture_fault(colour, FRAME.depth_m)
    assert said is not None
    assert word in said
    assert said.endswith(".")
    assert ": " in said


@pytest.mark.parametrize("value", [0.0, np.nan])
def test_no_depth_is_said(value: float) -> None:
    depth = np.full((480, 640), value, np.float32)
    assert "no depth" in str(picture_fault(FRAME.colour_bgr, depth))
    depth[:20] = 1.0
    assert "hardly any depth" in str(picture_fault(FRAME.colour_bgr, depth))


def test_a_frozen_picture_is_said_after_a_while_and_forgotten_when_it_moves() -> None:
    watch = PictureWatch()
    said = [watch.fault(FRAME.colour_bgr, FRAME.depth_m) for _ in range(17)]
    assert said[:15] == [None] * 15
    assert "same picture" in str(said[16])
    other = CAMERA.frame(4)
    assert watch.fault(other.colour_bgr, other.depth_m) is None
