"""What every camera must do; run over every implementation that needs no hardware."""

from __future__ import annotations

import sys
from collections.abc import Callable
from itertools import islice
from pathlib import Path

import cv2
import numpy as np
import pytest

from rehab_app.cameras import (
    Camera,
    Frame,
    Reconnecting,
    RecordedCamera,
    VideoCamera,
    VirtualCamera,
    hand_scene,
    scripted_motion,
    wear_markers,
)
from rehab_app.cameras.apart import Apart
from rehab_app.geometry.pinhole import Intrinsics
from rehab_app.hand.protocol import load_protocol
from rehab_app.recording.images import frame_records
from robot_iface.kinematics import average_hand
from sessions.errors import Refused
from sessions.records import SessionHeader
from sessions.store import SessionWriter

SMALL = Intrinsics(262.5, 262.5, 159.5, 119.5, 320, 240)
MISSING = 3


def virtual(realtime: bool = False) -> VirtualCamera:
    geometry, rng = average_hand(0.19), np.random.default_rng(1)
    scene = hand_scene(
        wear_markers(geometry, load_protocol("thesis25"), rng), scripted_motion("tapping"), rng
    )
    rate = 100.0 if realtime else 30.0
    return VirtualCamera(scene, realtime=realtime, rate_hz=rate, intrinsics=SMALL)


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A session of eight images with depth, of which one was lost."""
    return recorded(tmp_path_factory.mktemp("session") / "take.mcap", with_depth=True)


@pytest.fixture(scope="module")
def colour_session(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return recorded(tmp_path_factory.mktemp("colour") / "take.mcap", with_depth=False)


def recorded(path: Path, *, with_depth: bool) -> Path:
    header = SessionHeader(
        session_id="c" * 32,
        kind="take",
        subject_id="p-1",
        side="right",
        exercise="tapping",
        source="virtual-camera",
        software_version="0",
        utc_start_ns=10**18,
        monotonic_start_ns=0,
        consent_images=True,
    )
    camera = virtual()
    with SessionWriter(path, header) as writer:
        for index in (number for number in range(8) if number != MISSING):
            seen = camera.frame(index)
            depth = seen.depth_m if with_depth else None
            frame = Frame(seen.t_capture_ns, seen.colour_bgr, depth, seen.intrinsics)
            for topic, record in frame_records(frame, calibration=index == 0):
                writer.write(topic, record)
        writer.seal()
    return path


@pytest.fixture(scope="module")
def video(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("video") / "hand.avi"
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"MJPG"), 25.0, (320, 240))
    for index in range(8):
        writer.write(virtual().frame(index).colour_bgr)
    writer.release()
    return path


Make = Callable[[], Camera]


@pytest.fixture
def virtual_camera() -> Make:
    return virtual


@pytest.fixture
def virtual_realtime_camera() -> Make:
    return lambda: virtual(realtime=True)


@pytest.fixture
def recorded_camera(session: Path) -> Make:
    return lambda: RecordedCamera(session)


@pytest.fixture
def recorded_colour_camera(colour_session: Path) -> Make:
    return lambda: RecordedCamera(colour_session)


@pytest.fixture
def video_camera(video: Path) -> Make:
    return lambda: VideoCamera(video)


@pytest.fixture
def reconnecting_camera() -> Make:
    return lambda: Reconnecting(virtual)


CHILD = """
import sys
from multiprocessing.connection import Connection
import numpy as np
from rehab_app.cameras import VirtualCamera, hand_scene, scripted_motion, wear_markers
from rehab_app.cameras.apart_reader import read
from rehab_app.geometry.pinhole import Intrinsics
from rehab_app.hand.protocol import load_protocol
from robot_iface.kinematics import average_hand
geometry, rng = average_hand(0.19), np.random.default_rng(1)
worn = wear_markers(geometry, load_protocol("thesis25"), rng)
scene = hand_scene(worn, scripted_motion("tapping"), rng)
lens = Intrinsics(262.5, 262.5, 159.5, 119.5, 320, 240)
read(VirtualCamera(scene, realtime=False, rate_hz=30.0, intrinsics=lens), Connection(int(sys.argv[1])))
"""


@pytest.fixture
def apart_camera() -> Make:
    return lambda: Apart(virtual(), (sys.executable, "-c", CHILD, "{}"))


NAMES = (
    "apart",
    "virtual",
    "virtual_realtime",
    "recorded",
    "recorded_colour",
    "video",
    "reconnecting",
    "realsense",
)


@pytest.fixture(params=NAMES)
def make(request: pytest.FixtureRequest) -> Make:
    """Makes one kind of camera; OpenNI and the Kinect, which need a process of their own, have own files."""
    maker: Make = request.getfixturevalue(f"{request.param}_camera")
    return maker


def test_frames_rise_in_time_and_hold_colour_and_depth_together(make: Make) -> None:
    with make() as camera:
        frames = list(islice(camera.frames(), 5))
    times = np.array([frame.t_capture_ns for frame in frames])
    assert len(times) == 5
    assert (np.diff(times) > 0).all()
    size = (camera.intrinsics.height_px, camera.intrinsics.width_px)
    for frame in frames:
        assert frame.colour_bgr.shape == (*size, 3)
        assert frame.colour_bgr.dtype == np.uint8
        assert camera.has_depth == (frame.depth_m is not None)
        if frame.depth_m is not None:
            assert frame.depth_m.shape == size
            assert frame.depth_m.dtype == np.float32
        assert frame.intrinsics == camera.intrinsics
        assert frame.dropped >= 0


def test_gaps_in_time_are_counted_as_dropped(make: Make) -> None:
    with make() as camera:
        frames = list(islice(camera.frames(), 5))
    periods = np.rint(np.diff([frame.t_capture_ns for frame in frames]) * 1e-9 * camera.rate_hz)
    assert [frame.dropped for frame in frames[1:]] == [int(count) - 1 for count in periods]


def test_frames_stay_as_they_are_when_others_come(make: Make) -> None:
    with make() as camera:
        frames = camera.frames()
        first = next(frames)
        colour, depth = first.colour_bgr.copy(), None if first.depth_m is None else first.depth_m.copy()
        for _ in range(4):
            next(frames)
    assert np.array_equal(first.colour_bgr, colour)
    assert depth is None or np.array_equal(first.depth_m, depth)


def test_a_closed_camera_refuses(make: Make) -> None:
    with pytest.raises(Refused, match="open it"):
        next(make().frames())


def test_a_camera_closes_when_its_user_fails(make: Make) -> None:
    camera = make()
    with pytest.raises(KeyError), camera:
        raise KeyError
    with pytest.raises(Refused):
        next(camera.frames())


def test_a_camera_can_be_opened_again(make: Make) -> None:
    camera = make()
    for _ in range(2):
        with camera:
            assert isinstance(next(camera.frames()), Frame)


def test_the_name_is_fit_for_a_file(make: Make) -> None:
    assert make().name.replace("-", "").isalnum()


def test_a_camera_apart_shows_the_same_pictures(apart_camera: Make) -> None:
    with apart_camera() as camera, virtual() as here:
        for one, other in islice(zip(camera.frames(), here.frames(), strict=False), 3):
            assert isinstance(one, Frame)
            assert isinstance(other, Frame)
            assert np.array_equal(one.colour_bgr, other.colour_bgr)
            assert one.depth_m is not None
            assert other.depth_m is not None
            assert np.array_equal(one.depth_m, other.depth_m)


def test_a_lost_image_of_a_recording_is_counted(session: Path) -> None:
    with RecordedCamera(session) as camera:
        assert [frame.dropped for frame in camera.frames()] == [0, 0, 0, 1, 0, 0, 0]
