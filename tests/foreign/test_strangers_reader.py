"""A session opens in a reader that knows nothing of us: npm @mcap/core and protobufjs."""

from __future__ import annotations

import base64
import json
import os
import shutil
import subprocess
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from rehab_app.cameras import Frame
from rehab_app.geometry.pinhole import Intrinsics
from rehab_app.recording.images import frame_records
from sessions.records import FINGERTIPS, LANDMARKS, Event, SessionHeader, Transforms, columns_of
from sessions.records.therapy import RobotStateBlock
from sessions.records.topics import EVENTS, ROBOT_STATE, TRANSFORMS
from sessions.store import SessionWriter

HERE = Path(__file__).parent
UTC_NS = 1_790_000_000_000_000_001
FRAMES = 40


@pytest.fixture(scope="module")
def node() -> str:
    """The node program, or a skip that says what is missing; in CI a failure."""
    found = shutil.which("node")
    if found and (HERE / "node_modules" / "@mcap" / "core").is_dir():
        return found
    missing = "the stranger's reader needs Node and its packages: run tests/install-tools.sh"
    if os.environ.get("CI") == "true":
        pytest.fail(missing)
    pytest.skip(missing)


def landmarks_m(index: int) -> np.ndarray[Any, np.dtype[np.float64]]:
    return np.random.default_rng(index).normal(size=(len(LANDMARKS), 3))


def write_session(path: Path) -> None:
    header = SessionHeader(
        session_id="a" * 32,
        kind="take",
        subject_id="p-1",
        side="right",
        exercise="Faustschluß",
        source="virtual-camera",
        software_version="0",
        utc_start_ns=UTC_NS,
        monotonic_start_ns=0,
        consent_images=True,
    )
    turned = np.tile([1.0, 0.0, 0.0, 0.0], (len(LANDMARKS), 1))
    with SessionWriter(path, header) as writer:
        for index in range(FRAMES):
            t_ns = index * 33_000_000
            names = tuple(f"patient/{name}" for name in LANDMARKS)
            parents = ("palm",) * len(LANDMARKS)
            frames = Transforms(
                t_ns=t_ns,
                parents=parents,
                children=names,
                p_parent_child_m=landmarks_m(index),
                q_parent_child_wxyz=turned,
            )
            writer.write(TRANSFORMS, frames)
            writer.write(ROBOT_STATE, block(t_ns))
        writer.write(EVENTS, event())
        for topic, record in frame_records(picture(), calibration=True):
            writer.write(topic, record)
        writer.seal()


def picture() -> Frame:
    """A blue image with a ramp of depth, 0 to 47 mm from top to bottom."""
    colour = np.full((48, 64, 3), (200, 80, 20), np.uint8)
    depth = np.repeat(np.arange(48, dtype=np.float32)[:, None] * 0.001, 64, axis=1)
    return Frame(2_000_000, colour, depth, Intrinsics(50.0, 51.0, 31.5, 23.5, 64, 48))


def block(t_ns: int) -> RobotStateBlock:
    values: dict[str, Any] = {}
    for name, column in columns_of(RobotStateBlock).items():
        values[name] = np.full((50, 12) if len(column.shape) == 2 else 50, 0.25)
    values["t_ns"] = t_ns + np.arange(50) * 1_000_000
    values["safety_state"] = np.full(50, 3, np.uint8)
    return RobotStateBlock(**values)


def event() -> Event:
    texts = {"severity": "alarm", "cause": "e-stop", "category": "", "subject": "", "text": "Stop gedrückt."}
    return Event(t_ns=1_000_000, kind="stop", value=1.5, bound=2.0, **texts)


def test_a_stranger_finds_every_message(node: str, tmp_path: Path) -> None:
    path = tmp_path / "take.mcap"
    write_session(path)
    command = [node, str(HERE / "read-session.mjs"), str(path)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)

    images = {"/camera/calibration": 1, "/camera/color": 1, "/camera/depth": 1}
    assert found["counts"] == {"/tf": FRAMES, "/robot/state": FRAMES, "/events": 1} | images
    assert found["metadata"]["session"]["side"] == "right"
    assert found["metadata"]["session"]["exercise"] == "Faustschluß"
    assert found["attachments"] == ["overview"]
    assert int(found["first_log_time"]["/tf"]) == UTC_NS

    last = landmarks_m(FRAMES - 1)
    assert set(found["transforms"]) == {f"patient/{name}" for name in LANDMARKS}
    for row, name in enumerate(LANDMARKS):
        parent, *xyz = found["transforms"][f"patient/{name}"]
        assert parent == "palm"
        assert xyz == last[row].tolist()
    assert set(FINGERTIPS) <= {name.removeprefix("patient/") for name in found["transforms"]}

    robot = found["samples"]["/robot/state"]
    assert robot["rows"] == 50
    assert robot["q_rad"] == [0.25] * 600
    assert robot["safety_state"] == [3] * 50
    assert robot["t_ns"][1] == "1000000"
    assert found["samples"]["/events"]["text"] == "Stop gedrückt."

    lens = found["samples"]["/camera/calibration"]
    assert (lens["width"], lens["height"], lens["distortion_model"]) == (64, 48, "plumb_bob")
    assert lens["K"] == [50.0, 0.0, 31.5, 0.0, 51.0, 23.5, 0.0, 0.0, 1.0]
    assert lens["P"][:4] == [50.0, 0.0, 31.5, 0.0]
    assert (lens["D"], lens["R"]) == ([0.0] * 5, np.eye(3).ravel().tolist())

    colour = found["samples"]["/camera/color"]
    assert (colour["format"], colour["frame_id"]) == ("jpeg", "camera")
    image = cv2.imdecode(np.frombuffer(base64.b64decode(colour["data"]), np.uint8), cv2.IMREAD_COLOR)
    assert np.abs(image.astype(int) - picture().colour_bgr).max() <= 4

    depth = found["samples"]["/camera/depth"]
    assert (depth["encoding"], depth["width"], depth["height"], depth["step"]) == ("16UC1", 64, 48, 128)
    pixels = np.frombuffer(base64.b64decode(depth["data"]), "<u2").reshape(48, 64)
    assert (pixels == np.arange(48)[:, None]).all()
