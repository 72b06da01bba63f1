from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rehab_app.calibration import CalibratedCamera, Rectified, find_board, rectified
from rehab_app.cameras.frame import Frame, Outage
from rehab_app.errors import Refused
from rehab_app.geometry.lens import STRAIGHT
from rehab_app.geometry.pinhole import KINECT

POSE = (np.array([0.2, -0.3, 0.05]), np.array([-0.1, -0.06, 0.4]))


class Played:
    """A camera that plays frames it was given."""

    name = "played"
    rate_hz = 30.0
    has_depth = True

    def __init__(self, captures, intrinsics=KINECT):
        self.intrinsics = intrinsics
        self.captures = captures
        self.open = False

    def __enter__(self):
        self.open = True
        return self

    def __exit__(self, *_):
        self.open = False

    def frames(self):
        yield from self.captures


@pytest.fixture
def camera(scene):
    return CalibratedCamera(camera="played", intrinsics=scene.intrinsics, lens=scene.lens)


def frame_of(grey, depth=None):
    return Frame(5, np.repeat(grey[:, :, None], 3, axis=2), depth, KINECT)


def test_the_rectified_picture_is_that_of_the_pinhole(scene, camera):
    captures = [frame_of(scene.picture(*POSE)), Outage(6, "unplugged")]
    with Rectified(Played(captures), camera) as opened:
        frame, outage = opened.frames()
        assert opened.intrinsics == frame.intrinsics == scene.intrinsics
        assert (opened.name, opened.rate_hz, opened.has_depth) == ("played", 30.0, True)
    assert outage is captures[1]
    found = find_board(frame.colour_bgr[:, :, 0].copy(), scene.board, "a")
    straight = replace(scene, lens=STRAIGHT).project(*POSE)
    assert np.sqrt(((found.pixel_px - straight) ** 2).sum(axis=1).mean()) < 0.15
    assert np.abs(straight - scene.project(*POSE)).max() > 2.0


def test_depth_is_moved_but_never_mixed(scene, camera):
    depth = np.where(np.arange(640) % 7 < 3, np.float32(0.5), np.float32(0.9))[None].repeat(480, axis=0)
    frame = Rectified(Played([]), camera).rectified(frame_of(np.zeros((480, 640), np.uint8), depth))
    assert frame.depth_m.dtype == np.float32
    assert set(np.unique(frame.depth_m)) <= {np.float32(0.0), np.float32(0.5), np.float32(0.9)}
    middle = round(camera.intrinsics.cy_px), round(camera.intrinsics.cx_px)
    assert frame.depth_m[middle] == depth[middle]
    assert Rectified(Played([]), camera).rectified(frame_of(np.zeros((480, 640), np.uint8))).depth_m is None


def test_a_straight_lens_changes_no_pixel(scene, camera):
    straight = replace(camera, lens=STRAIGHT)
    raw = frame_of(scene.picture(*POSE))
    frame = Rectified(Played([]), straight).rectified(raw)
    assert frame.colour_bgr is raw.colour_bgr
    assert frame.intrinsics == scene.intrinsics


def test_another_resolution_is_refused_and_the_camera_given_back(camera):
    wide = Played([], replace(KINECT, width_px=1280, height_px=720))
    with pytest.raises(Refused, match="resolution of camera played is 1280 x 720"), Rectified(wide, camera):
        pass
    assert not wide.open
    with pytest.raises(Refused, match="a frame of camera played is 320 x 240"):
        Rectified(Played([]), camera).rectified(frame_of(np.zeros((240, 320), np.uint8)))


def test_without_a_calibration_the_camera_is_itself():
    played = Played([])
    assert rectified(played, None) is played
