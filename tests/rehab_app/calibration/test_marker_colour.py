from __future__ import annotations

import cv2
import numpy as np
import pytest

from rehab_app.calibration import CalibratedCamera
from rehab_app.calibration.marker_colour import frame_of, picture_of, pixel_named, with_colour
from rehab_app.cameras import virtual_camera
from rehab_app.cameras.frame import Outage
from rehab_app.errors import Refused
from rehab_app.geometry.pinhole import KINECT
from rehab_app.hand.protocol import load_protocol
from rehab_app.vision import colour_from_json

CAMERA = CalibratedCamera(camera="virtual", intrinsics=KINECT)


@pytest.fixture(scope="module")
def shown():
    """A frame of the virtual camera, and the middle of a marker in it."""
    with virtual_camera("still", "right", 2.0, load_protocol("thesis25"), seed=3) as camera:
        frame = frame_of(camera)
        truth = camera.truth(0.0)
    best = int(np.argmax(truth.seen))
    return frame, tuple(float(value) for value in truth.pixel_px[best])


@pytest.mark.parametrize("pointed_at", [True, False])
def test_the_colour_is_kept_with_the_camera(shown, pointed_at):
    frame, pixel = shown
    learnt = with_colour(CAMERA, frame.colour_bgr, frame.depth_m, pixel if pointed_at else None)
    blue, green, red = colour_from_json(learnt.colour).ink_bgr
    assert blue > green + 40
    assert blue > red + 40
    assert learnt.digest != CAMERA.digest
    assert learnt.intrinsics == CAMERA.intrinsics
    assert learnt.table()["colour"]["ink_bgr"]


def test_bad_input_is_one_sentence(shown, tmp_path):
    frame, _ = shown
    with pytest.raises(Refused, match="resolution of the picture is 320 x 240"):
        with_colour(CAMERA, cv2.resize(frame.colour_bgr, (320, 240)), None, (10.0, 10.0))
    with pytest.raises(Refused):
        with_colour(CAMERA, np.zeros((480, 640, 3), np.uint8), None, None)
    for text in ("320", "a,b", "-1,5", "nan,nan"):
        with pytest.raises(Refused, match="--at"):
            pixel_named(text)
    assert pixel_named(" 320, 240.5") == (320.0, 240.5)
    (tmp_path / "a.png").write_text("no picture")
    for name, value in (("a.png", "no image"), ("b.png", "not there")):
        with pytest.raises(Refused, match=value):
            picture_of(tmp_path / name)


def test_a_camera_that_ends_without_a_frame():
    class Dark:
        def frames(self):
            yield Outage(0, "unplugged")

    class Gone:
        def frames(self):
            yield from (Outage(half * 500_000_000, "unplugged") for half in range(10**9))

    with pytest.raises(Refused, match="without a frame"):
        frame_of(Dark())
    with pytest.raises(Refused, match="without a frame"):
        frame_of(Gone())
