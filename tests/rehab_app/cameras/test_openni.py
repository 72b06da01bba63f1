"""OpenNI 2 through the library's own Dummy device, in a process of its own.

The Dummy's threads outlive its streams, so that the library's farewell may crash; the process leaves without.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from importlib.util import find_spec
from itertools import islice
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from rehab_app.cameras import Frame, open_camera, openni_library
from rehab_app.cameras.openni import OpenNiCamera
from sessions.errors import Refused

PROGRAM = """
import json, os, sys
from itertools import islice
from rehab_app.cameras.openni import OpenNiCamera, uris
from sessions.errors import Refused
found = {"uris": uris()}
try:
    OpenNiCamera("no-such-device").__enter__()
except Refused as refusal:
    found["absent"] = str(refusal)
with OpenNiCamera("Dummy") as camera:
    lens = camera.intrinsics
    found["size"] = [lens.width_px, lens.height_px, lens.fx_px, lens.cx_px]
    found["rate_hz"] = camera.rate_hz
    frames = list(islice(camera.frames(), 8))
found["t_ns"] = [frame.t_capture_ns for frame in frames]
found["dropped"] = [frame.dropped for frame in frames]
found["shapes"] = [[frame.colour_bgr.shape, frame.depth_m.shape] for frame in frames]
found["deepest_m"] = [float(frame.depth_m.max()) for frame in frames]
found["blue"] = [int(frame.colour_bgr[..., 0].max()) for frame in frames]
try:
    next(camera.frames())
except Refused as refusal:
    found["closed"] = str(refusal)
print(json.dumps(found), flush=True)
os._exit(0)
"""


@pytest.fixture
def library() -> None:
    """A skip that says what is missing; in CI a failure."""
    if find_spec("openni") is None or openni_library.library_folder() is None:
        missing = "the OpenNI tests need the extra openni and its library: run tests/install-tools.sh"
        if os.environ.get("CI") == "true":
            pytest.fail(missing)
        pytest.skip(missing)


@pytest.fixture
def dummy(library: None) -> dict[str, list[float]]:
    """What the Dummy device gave."""
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM], capture_output=True, text=True, check=False, timeout=60
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_the_dummy_device_gives_paired_images_in_metres(dummy: dict[str, list[float]]) -> None:
    assert dummy["size"] == [320, 240, 262.5, 159.5]
    assert dummy["rate_hz"] == 30.0
    assert dummy["shapes"] == [[[240, 320, 3], [240, 320]]] * 8
    assert dummy["deepest_m"] == [pytest.approx(2.0)] * 8  # the Dummy draws a square 2000 mm away
    assert min(dummy["blue"]) == 255
    periods = np.rint(np.diff(dummy["t_ns"]) * 30e-9).astype(int)
    assert (np.diff(dummy["t_ns"]) > 0).all()
    assert dummy["dropped"][1:] == (periods - 1).tolist()


def test_what_is_not_there_is_a_sentence(dummy: dict[str, str]) -> None:
    assert "must be connected: plug it in" in dummy["absent"]
    assert "open it before" in dummy["closed"]


def test_a_recording_reads_it_without_its_library(library: None) -> None:
    """The library, whose farewell may crash, is in another process."""
    with open_camera("openni:Dummy") as camera:
        frames = list(islice(camera.frames(), 8))
        assert camera.intrinsics.width_px == 320
    assert [isinstance(one, Frame) and one.colour_bgr.shape for one in frames] == [(240, 320, 3)] * 8
    assert "libOpenNI2" not in Path("/proc/self/maps").read_text()


def test_a_missing_extra_names_itself(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "openni.openni2", None)
    with pytest.raises(Refused, match=r"pip install 'rehab-app\[openni\]'"):
        OpenNiCamera().__enter__()
    monkeypatch.setitem(sys.modules, "pyrealsense2", None)
    from rehab_app.cameras.realsense import RealSenseCamera

    with pytest.raises(Refused, match=r"pip install 'rehab-app\[realsense\]'"):
        RealSenseCamera().__enter__()


def test_a_missing_library_names_its_package(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "openni.openni2", SimpleNamespace(is_initialized=lambda: False))
    monkeypatch.setattr(openni_library, "library_folder", lambda: None)
    with pytest.raises(Refused, match="apt-get install libopenni2-0"):
        OpenNiCamera().__enter__()
