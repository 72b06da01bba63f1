"""RealSense through the driver's own software device: alignment, lens, numbers, unplugging."""

from __future__ import annotations

from itertools import islice
from typing import Any

import numpy as np
import pytest

from rehab_app.cameras import Frame, Outage, Reconnecting
from rehab_app.cameras.realsense import RealSenseCamera
from sessions.errors import Refused

WIDTH, HEIGHT, RATE_HZ = 320, 240, 30


def camera(device: Any) -> RealSenseCamera:
    return RealSenseCamera(size_px=(WIDTH, HEIGHT), rate_hz=RATE_HZ, find=device.find)


def test_depth_is_aligned_to_colour_and_in_metres(software_realsense: Any) -> None:
    with camera(software_realsense()) as source:
        frame = next(iter(source.frames()))
    assert source.intrinsics.fx_px == 300.0
    # The left half of the depth image is a plane at 0.5 m. Its edge, straight ahead of the depth camera, is
    # met by the colour camera 50 mm beside it at 300 * 0.05 / 0.5 + 159.5 = 189.5 px.
    assert np.allclose(frame.depth_m[:, :186], 0.5)
    assert (frame.depth_m[:, 193:] == 0.0).all()


def test_channels_are_blue_green_red(software_realsense: Any) -> None:
    with camera(software_realsense(rgb=True)) as source:
        frame = next(iter(source.frames()))
    assert tuple(frame.colour_bgr[5, 5, :2]) == (220, 10)


def test_lost_captures_are_counted_by_the_camera_s_numbers(software_realsense: Any) -> None:
    device = software_realsense()
    device.missing = set(range(0, 400, 5))
    with camera(device) as source:
        frames = list(islice(source.frames(), 20))
    assert {frame.dropped for frame in frames[1:]} == {0, 1}
    assert sum(frame.dropped for frame in frames[1:]) in (4, 5)


def test_a_stated_lens_is_straightened(software_realsense: Any) -> None:
    barrel = software_realsense(coefficients=[-0.2, 0.05, 0.0, 0.0, 0.0])
    with camera(barrel) as source:
        lens = source._lens
        next(iter(source.frames()))
    u, v = lens._maps
    # Brown's model: a ray (x, y) is seen at (x, y) (1 + k1 r^2 + k2 r^4)
    x, y = (300 - 159.5) / 300.0, (40 - 119.5) / 300.0
    bend = 1.0 - 0.2 * (x * x + y * y) + 0.05 * (x * x + y * y) ** 2
    assert u[40, 300] == pytest.approx(300.0 * x * bend + 159.5, abs=0.05)
    assert v[40, 300] == pytest.approx(300.0 * y * bend + 119.5, abs=0.05)


def test_unplugging_is_told_twice_a_second_and_replugging_goes_on(software_realsense: Any) -> None:
    device = software_realsense()
    with Reconnecting(lambda: camera(device)) as source:
        captures = source.frames()
        before = [next(captures) for _ in range(3)]
        device.plugged.clear()
        while isinstance(told := next(captures), Frame):
            before.append(told)
        second = next(captures)
        device.plugged.set()
        while isinstance(after := next(captures), Outage):
            continue
    assert isinstance(told, Outage)
    assert "plug it in" in told.reason
    assert second.t_ns - told.t_ns > 4e8
    assert after.t_capture_ns > before[-1].t_capture_ns
    assert after.dropped >= 25  # it was away for a second at least, at 30 Hz


def test_absent_wrong_resolution_and_second_use_are_sentences(software_realsense: Any) -> None:
    device = software_realsense()
    with pytest.raises(Refused, match="not found"):
        RealSenseCamera("9999", find=device.find).__enter__()
    with pytest.raises(Refused, match=r"320 x 240.*must be 640 x 480 px at 30 Hz"):
        RealSenseCamera(find=device.find).__enter__()
    with pytest.raises(Refused, match="open it"):
        _ = camera(device).intrinsics
