"""What every camera must do; run over every implementation that needs no hardware."""

from __future__ import annotations

from collections.abc import Callable
from itertools import islice

import numpy as np
import pytest

from rehab_app.cameras import Camera, VirtualCamera, hand_scene, scripted_motion, wear_markers
from rehab_app.hand.protocol import load_protocol
from robot_iface.kinematics import average_hand
from sessions.errors import Refused


def virtual(realtime: bool = False) -> Camera:
    geometry, rng = average_hand(0.19), np.random.default_rng(1)
    scene = hand_scene(
        wear_markers(geometry, load_protocol("thesis25"), rng), scripted_motion("tapping"), rng
    )
    return VirtualCamera(scene, realtime=realtime, rate_hz=100.0 if realtime else 30.0)


CAMERAS = {"virtual": virtual, "virtual-realtime": lambda: virtual(realtime=True)}


@pytest.fixture(params=CAMERAS.values(), ids=CAMERAS.keys())
def make(request: pytest.FixtureRequest) -> Callable[[], Camera]:
    return request.param


def test_frames_rise_in_time_and_hold_colour_and_depth_together(make: Callable[[], Camera]) -> None:
    with make() as camera:
        frames = list(islice(camera.frames(), 5))
    times = np.array([frame.t_capture_ns for frame in frames])
    assert (np.diff(times) > 0).all()
    size = (camera.intrinsics.height_px, camera.intrinsics.width_px)
    for frame in frames:
        assert frame.colour_bgr.shape == (*size, 3)
        assert frame.colour_bgr.dtype == np.uint8
        assert frame.depth_m.shape == size
        assert frame.depth_m.dtype == np.float32
        assert frame.intrinsics == camera.intrinsics
        assert frame.dropped >= 0


def test_gaps_in_time_are_counted_as_dropped(make: Callable[[], Camera]) -> None:
    with make() as camera:
        frames = list(islice(camera.frames(), 5))
    periods = np.rint(np.diff([frame.t_capture_ns for frame in frames]) * 1e-9 * camera.rate_hz)
    assert [frame.dropped for frame in frames[1:]] == [int(count) - 1 for count in periods]


def test_a_closed_camera_refuses(make: Callable[[], Camera]) -> None:
    with pytest.raises(Refused, match="open it"):
        next(make().frames())


def test_a_camera_closes_when_its_user_fails(make: Callable[[], Camera]) -> None:
    camera = make()
    with pytest.raises(KeyError), camera:
        raise KeyError
    with pytest.raises(Refused):
        next(camera.frames())


def test_the_name_is_fit_for_a_file(make: Callable[[], Camera]) -> None:
    assert make().name.replace("-", "").isalnum()
