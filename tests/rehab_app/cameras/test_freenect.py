"""The Kinect v1 through the real binding and libfreenect's stand-in, which plays a recording made here."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from rehab_app.cameras import freenect_library, kinect_depth
from rehab_app.cameras.freenect import FreenectCamera
from rehab_app.geometry.pinhole import KINECT, Intrinsics
from sessions.errors import Refused

FRAMES, MISSING = 7, 4
TICKS_PER_FRAME = 2_000_000  # 60 MHz, 30 Hz
FIRST_TICK = 2**32 - 3 * TICKS_PER_FRAME  # the 32-bit counter starts anew within the recording
RAW = 700
FAKES = (Path("/usr/lib/x86_64-linux-gnu"), Path("/usr/lib/aarch64-linux-gnu"), Path("/usr/lib"))

PROGRAM = """
import json
from rehab_app.cameras import Frame, Reconnecting
from rehab_app.cameras.freenect import FreenectCamera
found = {"frames": [], "outage": ""}
with Reconnecting(FreenectCamera) as camera:
    found["has_depth"], found["name"] = camera.has_depth, camera.name
    for capture in camera.frames():
        if not isinstance(capture, Frame):
            found["outage"] = capture.reason
            break
        depth = capture.depth_m
        found["frames"].append({
            "t_ns": capture.t_capture_ns, "dropped": capture.dropped,
            "bgr": capture.colour_bgr[100, 200].tolist(), "far_bgr": capture.colour_bgr[479, 639].tolist(),
            "depth_m": float(depth[240, 300]), "columns": [int(depth.any(axis=0).argmax()),
            640 - int(depth.any(axis=0)[::-1].argmax())],
        })
print("\\n" + json.dumps(found), flush=True)
"""


@pytest.fixture(scope="module")
def fake() -> Path:
    """The stand-in, or a skip that says what is missing; in CI a failure."""
    for folder in FAKES:
        path = folder / "fakenect" / freenect_library.LIBRARY
        if path.is_file():
            return path
    missing = "the Kinect tests need libfreenect's fakenect: run tests/install-tools.sh"
    if os.environ.get("CI") == "true":
        pytest.fail(missing)
    pytest.skip(missing)


@pytest.fixture(scope="module")
def played(fake: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, list[dict[str, object]]]:
    """What the camera made of a recording: a wall, half of it without depth; colour tells the frame."""
    folder = tmp_path_factory.mktemp("dump")
    names: list[str] = []
    raw = np.full((480, 640), RAW, "<u2")
    raw[:, 320:] = kinect_depth.NO_DEPTH
    for index in (number for number in range(FRAMES) if number != MISSING):
        ticks, t_s = (FIRST_TICK + index * TICKS_PER_FRAME) % 2**32, 100.0 + index / 30.0
        rgb = np.full((480, 640, 3), (200, 20, 10 * index), np.uint8)
        rgb[479, 639] = (1, 2, 3)
        for kind, later, header, pixels in (
            ("r", 0, b"P6 640 480 255 \n", rgb),
            ("d", 300, b"P5 640 480 65535 \n", raw),
        ):
            name = (
                f"{kind}-{t_s + later * 1e-6:f}-{(ticks + later) % 2**32}.{'ppm' if kind == 'r' else 'pgm'}"
            )
            (folder / name).write_bytes(header + pixels.tobytes())
            names.append(name)
    (folder / "INDEX.txt").write_text("\n".join(names) + "\n")
    environment = os.environ | {"LD_PRELOAD": str(fake), "FAKENECT_PATH": str(folder)}
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM],
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
        env=environment,
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout.strip().splitlines()[-1])


def test_every_frame_comes_with_its_own_colour(played: dict[str, list[dict[str, object]]]) -> None:
    kept = [index for index in range(FRAMES) if index != MISSING]
    assert [frame["bgr"] for frame in played["frames"]] == [[10 * index, 20, 200] for index in kept]
    assert all(frame["far_bgr"] == [3, 2, 1] for frame in played["frames"])
    assert played["has_depth"]
    assert played["name"] == "kinect"


def test_time_goes_on_where_the_counter_starts_anew(played: dict[str, list[dict[str, object]]]) -> None:
    spacing = np.diff([frame["t_ns"] for frame in played["frames"]])
    assert np.rint(spacing * 30e-9).astype(int).tolist() == [1, 1, 1, 2, 1]
    assert [frame["dropped"] for frame in played["frames"]] == [0, 0, 0, 0, 1, 0]


def test_raw_depth_becomes_metres_registered_to_colour(played: dict[str, list[dict[str, object]]]) -> None:
    z = 0.1236 * np.tan(RAW / 2842.5 + 1.1863)
    # columns 0 and 319 of the infrared image, seen by a camera 25 mm to its right with 525 px
    first, last = (525.0 * ((column - 319.5) / 580.0 - 0.025 / z) + 319.5 for column in (0, 319))
    for frame in played["frames"]:
        assert frame["depth_m"] == pytest.approx(z, rel=1e-5)
        assert frame["columns"][0] == pytest.approx(first, abs=1.0)
        assert frame["columns"][1] == pytest.approx(last + 1, abs=1.0)


def test_the_end_of_the_recording_is_told_as_unplugged(played: dict[str, str]) -> None:
    assert "Kinect" in played["outage"]
    assert "plug it in again" in played["outage"]


def test_depth_agrees_with_another_s_fit_of_the_same_sensor() -> None:
    raw = np.arange(550, 1010, dtype=np.uint16)
    metres = kinect_depth.metres(raw)
    linear = 1.0 / (3.3309495161 - 0.0030711016 * raw)  # N. Burrus: disparity is linear in the raw value
    assert metres == pytest.approx(linear, rel=0.06)
    assert (np.diff(metres) > 0).all()
    assert kinect_depth.metres(np.array([2047, 4000, 0], np.uint16)).tolist() == [0.0, 0.0, 0.0]


def test_registration_hides_what_is_behind() -> None:
    wall = np.full((480, 640), 2.0, np.float32)
    wall[200:280, 300:340] = 1.0
    seen = kinect_depth.registered(wall, KINECT)
    near = np.argwhere(seen == 1.0)
    assert near[:, 1].min() == pytest.approx(525.0 * ((300 - 319.5) / 580 - 0.025) + 319.5, abs=1.0)
    assert set(np.unique(seen)) <= {0.0, 1.0, 2.0}


def test_intrinsics_of_another_resolution_are_refused() -> None:
    with pytest.raises(Refused, match="must be 640 x 480 px"):
        FreenectCamera(intrinsics=Intrinsics(500.0, 500.0, 320.0, 240.0, 1280, 1024))


def test_a_missing_library_names_its_package(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(freenect_library, "LIBRARY", "libfreenect-absent.so")
    with pytest.raises(Refused, match=r"apt-get install libfreenect0\.5"):
        FreenectCamera().__enter__()
