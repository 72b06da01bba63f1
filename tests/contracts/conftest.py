"""A RealSense camera without hardware: the driver's own software device, fed by a thread."""

from __future__ import annotations

import os
import threading
from collections.abc import Iterator
from importlib import import_module
from typing import Any

import numpy as np
import pytest

from rehab_app.cameras.realsense import RealSenseCamera

WIDTH, HEIGHT, RATE_HZ = 320, 240, 30
DEPTH_M, BASELINE_M = 0.5, 0.05


class SoftwareRealSense:
    """Two sensors of one device. The left half of the depth is a plane; colour shows the frame's index."""

    def __init__(self, rs: Any, *, rgb: bool = False, coefficients: list[float] | None = None) -> None:
        self._rs = rs
        self.device = rs.software_device()
        self.device.register_info(rs.camera_info.serial_number, "0042")
        self._depth, self._colour = self.device.add_sensor("Depth"), self.device.add_sensor("Color")
        self._depth_profile = self._stream(self._depth, rs.stream.depth, 0, 2, rs.format.z16, 190.0)
        self._colour_profile = self._stream(
            self._colour,
            rs.stream.color,
            1,
            3,
            rs.format.rgb8 if rgb else rs.format.bgr8,
            300.0,
            coefficients,
        )
        apart = rs.extrinsics()
        apart.rotation, apart.translation = [1, 0, 0, 0, 1, 0, 0, 0, 1], [BASELINE_M, 0.0, 0.0]
        self._depth_profile.register_extrinsics_to(self._colour_profile, apart)
        self._depth.add_read_only_option(rs.option.depth_units, 0.001)
        self.device.create_matcher(rs.matchers.default)
        self.missing: set[int] = set()
        self.plugged = threading.Event()
        self.plugged.set()
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._feed)
        self._thread.start()

    def stop(self) -> None:
        self._over.set()
        self._thread.join()

    def find(self, rs: Any, serial: str | None) -> Any:
        return self.device if self.plugged.is_set() and serial in (None, "0042") else None

    def _stream(
        self,
        sensor: Any,
        kind: Any,
        uid: int,
        bytes_px: int,
        form: Any,
        focal: float,
        coefficients: Any = None,
    ) -> Any:
        lens = self._rs.intrinsics()
        lens.width, lens.height, lens.fx, lens.fy = WIDTH, HEIGHT, focal, focal
        lens.ppx, lens.ppy = 0.5 * (WIDTH - 1), 0.5 * (HEIGHT - 1)
        lens.model = self._rs.distortion.brown_conrady
        lens.coeffs = coefficients or [0.0] * 5
        stream = self._rs.video_stream()
        stream.type, stream.uid, stream.bpp, stream.fmt = kind, uid, bytes_px, form
        stream.width, stream.height, stream.fps, stream.intrinsics = WIDTH, HEIGHT, RATE_HZ, lens
        return sensor.add_video_stream(stream)

    def _feed(self) -> None:
        index = 0
        while not self._over.wait(0.01):
            index += 1
            if index in self.missing or not self.plugged.is_set():
                continue
            depth = np.full((HEIGHT, WIDTH), round(1000 * DEPTH_M), np.uint16)
            depth[:, WIDTH // 2 :] = 0
            colour = np.full((HEIGHT, WIDTH, 3), (index % 200, 10, 220), np.uint8)
            self._send(self._depth, self._depth_profile, depth, index)
            self._send(self._colour, self._colour_profile, colour, index)

    def _send(self, sensor: Any, profile: Any, pixels: np.ndarray[Any, Any], index: int) -> None:
        frame = self._rs.software_video_frame()
        frame.bpp = pixels.itemsize * (pixels.shape[2] if pixels.ndim == 3 else 1)
        frame.stride = WIDTH * frame.bpp
        frame.timestamp, frame.frame_number = index * 1000.0 / RATE_HZ, index
        frame.domain = self._rs.timestamp_domain.hardware_clock
        frame.profile = profile.as_video_stream_profile()
        frame.pixels, frame.depth_units = pixels, 0.001
        sensor.on_video_frame(frame)


@pytest.fixture
def software_realsense() -> Iterator[Any]:
    """Makes software cameras, and stops them."""
    try:
        rs: Any = import_module("pyrealsense2")
    except ImportError:
        missing = "the RealSense tests need the extra realsense: pip install '.[realsense]'"
        if os.environ.get("CI") == "true":
            pytest.fail(missing)
        pytest.skip(missing)
    made: list[SoftwareRealSense] = []

    def make(**options: Any) -> SoftwareRealSense:
        made.append(SoftwareRealSense(rs, **options))
        return made[-1]

    yield make
    for one in made:
        one.stop()


@pytest.fixture
def realsense_camera(software_realsense: Any) -> Any:
    """Makes a RealSense camera over a software device."""

    def make() -> RealSenseCamera:
        device = software_realsense()
        return RealSenseCamera(size_px=(WIDTH, HEIGHT), rate_hz=RATE_HZ, find=device.find)

    return make
