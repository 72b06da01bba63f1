"""Which cameras there are, how names become cameras, and a short look through one."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from types import TracebackType
from typing import Any

import cv2
import numpy as np
import pytest

from rehab_app.cameras import (
    Frame,
    Outage,
    Reconnecting,
    VideoCamera,
    VirtualCamera,
    drivers,
    freenect_library,
    list_cameras,
    listing,
    open_camera,
    openni_library,
    realsense,
    webcam,
)
from rehab_app.cameras.apart import Apart
from rehab_app.cameras.lease import CameraLease
from rehab_app.cameras.lost import missing_extra
from rehab_app.cameras.preview import look_through
from rehab_app.cameras.webcam import Webcam, webcam_indices
from rehab_app.geometry.pinhole import Intrinsics
from sessions.errors import Refused

DEPTH_CAMERAS = ("realsense", "kinect", "openni")


@pytest.fixture
def machine(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A machine with two webcams, a RealSense and two Kinects, without OpenNI; its device folder."""
    for name in ("video0", "video2", "video10", "null"):
        (tmp_path / name).touch()
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    monkeypatch.setattr(webcam, "_DEVICES", tmp_path)
    monkeypatch.setattr(realsense, "serials", lambda: (("0042", "D435"),))
    monkeypatch.setattr(freenect_library, "load", lambda: None)
    monkeypatch.setattr(freenect_library, "count", lambda _: 2)

    def absent() -> tuple[str, ...]:
        raise missing_extra("OpenNI camera", "openni")

    monkeypatch.setattr(openni_library, "uris", absent)
    monkeypatch.setattr(drivers, "look_apart", lambda: [drivers.look(kind) for kind in DEPTH_CAMERAS])
    return tmp_path


def test_every_kind_is_listed_with_its_state(machine: Path) -> None:
    lease = CameraLease("kinect:1")
    lease.take()
    try:
        found = {one.id: one for one in list_cameras()}
    finally:
        lease.release()
    states = {name: one.state for name, one in found.items()}
    assert states == {
        "virtual": "ready",
        "realsense:0042": "ready",
        "kinect:0": "ready",
        "kinect:1": "busy",
        "openni": "unavailable",
        "webcam:0": "ready",
        "webcam:2": "ready",
        "webcam:10": "ready",
    }
    assert found["openni"].remedy == "Run pip install 'rehab-app[openni]'."
    assert not found["webcam:0"].has_depth
    assert webcam_indices() == (0, 2, 10)


def test_a_library_that_brings_its_process_down_is_a_sentence_and_the_others_are_still_told() -> None:
    row = '{"kind": "realsense", "cameras": [["realsense:0042", "D435"]], "remedy": ""}'
    crash = f"import os; print('noise'); print({row!r}, flush=True); os.abort()"
    hang = f"import time; print({row!r}, flush=True); time.sleep(60)"
    for program, patience_s in ((crash, 20.0), (hang, 2.0)):
        there, *failed = drivers.look_apart((sys.executable, "-c", program), patience_s)
        assert there == drivers.Found("realsense", (("realsense:0042", "D435"),))
        assert [one.kind for one in failed] == ["kinect", "openni"]
        assert all("plug it in again" in one.remedy for one in failed)


def test_this_machines_libraries_answer_from_their_own_process() -> None:
    before = set(Path("/proc/self/task").iterdir())
    found = drivers.look_apart()
    assert [one.kind for one in found] == list(DEPTH_CAMERAS)
    assert not [one for one in found if "fails" in one.remedy]
    assert set(Path("/proc/self/task").iterdir()) <= before


@pytest.mark.parametrize(("opened", "listed"), [("kinect", "kinect:0"), ("realsense", "realsense:0042")])
def test_a_camera_that_is_recorded_from_is_busy(
    machine: Path, opened: str, listed: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Apart, "__enter__", lambda self: self)
    with open_camera(opened):
        assert {one.id: one.state for one in list_cameras()}[listed] == "busy"
        with pytest.raises(Refused, match="in use by another program"):
            open_camera(opened).__enter__()
    assert {one.id: one.state for one in list_cameras()}[listed] == "ready"


def test_what_is_listed_can_be_opened(machine: Path) -> None:
    for one in list_cameras():
        assert open_camera(one.id).has_depth == one.has_depth


def test_the_colour_stream_of_a_depth_camera_is_no_webcam(
    machine: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Path, "read_text", lambda *_, **__: "Intel(R) RealSense(TM) Depth Camera 435\n")
    monkeypatch.setattr(Path, "is_file", lambda _: True)
    monkeypatch.setattr(listing, "webcam_indices", lambda: (0,))
    assert not [one for one in list_cameras() if one.id.startswith("webcam")]


def test_names_become_cameras(tmp_path: Path) -> None:
    path = tmp_path / "hand.avi"
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"MJPG"), 20.0, (64, 48))
    for _ in range(4):
        writer.write(np.full((48, 64, 3), 90, np.uint8))
    writer.release()
    assert isinstance(open_camera("virtual"), VirtualCamera)
    assert isinstance(open_camera("virtual:tapping"), VirtualCamera)
    assert isinstance(open_camera("virtual:mixed:hard"), VirtualCamera)
    assert isinstance(open_camera("webcam:1"), Reconnecting)
    lens = Intrinsics(50.0, 50.0, 31.5, 23.5, 64, 48)
    for name in (str(path), f"video:{path}"):
        camera = open_camera(name, intrinsics=lens)
        assert isinstance(camera, VideoCamera)
        assert camera.intrinsics == lens


@pytest.mark.parametrize(
    "name", ["", "camera", "webcam:x", "webcam:-1", "webcam:9999", "kinect:²", "video:", "usb:0"]
)
def test_names_that_mean_nothing_are_a_sentence(name: str) -> None:
    with pytest.raises(Refused, match="rehab-app camera list"):
        open_camera(name)


def test_a_webcam_that_is_not_there_or_gives_nothing_is_a_sentence(machine: Path) -> None:
    with pytest.raises(Refused, match="plug it in"):
        Webcam(7).__enter__()
    with pytest.raises(Refused, match="in use by another program"):
        Webcam(0).__enter__()  # a device node that nothing answers behind


class Driver:
    """A capture device as OpenCV shows it: 30 Hz by its own clock, one frame lost, gone after six."""

    def __init__(self, width: int, height: int) -> None:
        self._size, self._count, self._set = (height, width), 0, {}
        self.released = False

    def isOpened(self) -> bool:
        return True

    def set(self, key: int, value: float) -> None:
        self._set[key] = value

    def get(self, key: int) -> float:
        late = 1 if self._count > 3 else 0
        return {cv2.CAP_PROP_FPS: 30.0, cv2.CAP_PROP_POS_MSEC: (self._count + late) * 1e3 / 30.0}[key]

    def read(self) -> tuple[bool, Any]:
        self._count += 1
        if self._count > 6:
            return False, None
        return True, np.full((*self._size, 3), self._count, np.uint8)

    def release(self) -> None:
        self.released = True


def test_a_webcam_keeps_the_drivers_time_and_tells_when_it_goes(
    machine: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    driver = Driver(640, 480)
    monkeypatch.setattr(webcam, "_opened", lambda _: driver)
    monkeypatch.setattr(webcam.time, "monotonic_ns", lambda: 1_000_000_000)
    with Webcam(0) as camera:
        met: list[Frame] = []
        with pytest.raises(Exception, match="plug it in again"):
            met += camera.frames()
        captures = camera.frames()
    assert [round(frame.t_capture_ns * 30e-9) for frame in met] == [2, 3, 5, 6, 7]
    assert [frame.dropped for frame in met] == [0, 0, 1, 0, 0]
    assert driver.released
    with pytest.raises(Refused, match="open it"):
        next(captures)
    assert camera.intrinsics_assumed


def test_a_webcam_of_another_resolution_is_refused(machine: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    driver = Driver(1280, 720)
    monkeypatch.setattr(webcam, "_opened", lambda _: driver)
    with pytest.raises(Refused, match="640 x 480 px, but must be 1280 x 720 px"):
        Webcam(0, Intrinsics(525.0, 525.0, 319.5, 239.5, 640, 480)).__enter__()
    assert driver.released


class Scripted:
    """A camera that gives what it is told to."""

    name = "scripted"
    has_depth = True
    rate_hz = 10.0
    intrinsics = Intrinsics(50.0, 50.0, 31.5, 23.5, 64, 48)

    def __init__(self, captures: list[Frame | Outage]) -> None:
        self._captures = captures

    def __enter__(self) -> Scripted:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        return

    def frames(self) -> Iterator[Frame | Outage]:
        yield from self._captures


def frame(index: int) -> Frame:
    depth = np.zeros((48, 64), np.float32)
    depth[:, :16] = 0.7
    return Frame(
        index * 100_000_000, np.full((48, 64, 3), 51, np.uint8), depth, Scripted.intrinsics, index % 2
    )


def test_a_look_sums_up_what_was_seen() -> None:
    captures: list[Frame | Outage] = [frame(index) for index in range(9)]
    captures.insert(3, Outage(250_000_000, "It is gone."))
    look = look_through(Scripted(captures), 0.5)
    assert look.frames == 6
    assert look.rate_hz == pytest.approx(10.0)
    assert look.depth_share == 0.25
    assert look.depth_m == pytest.approx(0.7)
    assert look.brightness == pytest.approx(0.2)
    assert look.dropped == 3
    assert look.outages == ("It is gone.",)
    assert look.last.t_capture_ns == 500_000_000
    flat = look_through(Scripted([replace(frame(0), depth_m=None)]), 0.5)
    assert (flat.depth_share, flat.depth_m) == (None, None)


def test_a_look_at_nothing_is_a_sentence() -> None:
    silence: list[Frame | Outage] = [Outage(index * 500_000_000, "It is gone.") for index in range(99)]
    with pytest.raises(Refused, match="It is gone"):
        look_through(Scripted(silence), 2.0)
    with pytest.raises(Refused, match="without frames"):
        look_through(Scripted([]), 2.0)
    with pytest.raises(Refused, match="60 s"):
        look_through(Scripted([]), 1e9)
