"""Every marker detector keeps the port's promises."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rehab_app.cameras import VirtualCamera, virtual_camera
from rehab_app.geometry.view import View
from rehab_app.hand.protocol import load_protocol
from rehab_app.vision import DETECTORS, make_detector, named_colour, protocol_colour
from sessions.errors import Refused


@pytest.fixture(scope="module")
def source() -> VirtualCamera:
    return virtual_camera("open_close", "right", 6.0, load_protocol("thesis25"), seed=4)


@pytest.mark.parametrize("name", DETECTORS)
def test_it_finds_the_markers_where_they_are(name: str, source: VirtualCamera) -> None:
    frame, truth = source.frame(12), source.truth(12 / 30)
    seen = make_detector(name).detect(123, frame.colour_bgr, frame.depth_m, frame.intrinsics)
    assert seen.t_capture_ns == 123
    assert len(seen) >= 22
    apart = np.linalg.norm(truth.pixel_px[:, None] - seen.pixel_px, axis=2).min(axis=0)
    assert np.median(apart) < 0.3
    assert ((seen.similarity > 0) & (seen.similarity <= 1 + 1e-9)).all()
    point = np.linalg.norm(truth.markers.p_camera_m[:, None] - seen.p_camera_m, axis=2).min(axis=0)
    assert np.median(point) < 0.002
    assert (np.linalg.eigvalsh(seen.covariance_m2) > 0).all()


@pytest.mark.parametrize("name", DETECTORS)
def test_it_remembers_nothing_and_changes_nothing(name: str, source: VirtualCamera) -> None:
    first, other = source.frame(12), source.frame(60)
    detector = make_detector(name)
    before = first.colour_bgr.copy()
    one = detector.detect(0, first.colour_bgr, first.depth_m, first.intrinsics)
    detector.detect(1, other.colour_bgr, other.depth_m, other.intrinsics)
    again = detector.detect(0, first.colour_bgr, first.depth_m, first.intrinsics)
    assert np.array_equal(one.pixel_px, again.pixel_px)
    assert np.array_equal(one.p_camera_m, again.p_camera_m)
    assert np.array_equal(before, first.colour_bgr)


@pytest.mark.parametrize("name", DETECTORS)
def test_it_does_without_depth(name: str, source: VirtualCamera) -> None:
    frame = source.frame(12)
    seen = make_detector(name).detect(0, frame.colour_bgr, None, frame.intrinsics)
    assert len(seen) >= 20
    assert np.isnan(seen.p_camera_m).all()
    assert np.allclose(np.linalg.norm(seen.ray_camera, axis=1), 1.0)
    assert (seen.ray_std_rad > 0).all()


@pytest.mark.parametrize("name", DETECTORS)
def test_a_second_camera_speaks_in_the_frame_of_the_first(name: str, source: VirtualCamera) -> None:
    frame = source.frame(12)
    view = View(1, np.diag([-1.0, 1.0, -1.0]), np.array([0.0, 0.0, 1.5]))
    detector = make_detector(name)
    own = detector.detect(0, frame.colour_bgr, frame.depth_m, frame.intrinsics)
    seen = detector.detect(0, frame.colour_bgr, frame.depth_m, frame.intrinsics, view=view)
    assert (seen.view == 1).all()
    assert seen.p_camera_m == pytest.approx(own.p_camera_m @ view.rotation_tracking_camera.T + [0, 0, 1.5])


@pytest.mark.parametrize("name", DETECTORS)
@pytest.mark.parametrize("value", [0, 255])
def test_a_black_or_white_picture_holds_nothing(name: str, value: int, source: VirtualCamera) -> None:
    colour = np.full((480, 640, 3), value, np.uint8)
    seen = make_detector(name).detect(0, colour, np.zeros((480, 640), np.float32), source.intrinsics)
    assert len(seen) == 0


@pytest.mark.parametrize("name", DETECTORS)
def test_a_picture_of_another_size_is_refused(name: str, source: VirtualCamera) -> None:
    colour = np.zeros((240, 320, 3), np.uint8)
    with pytest.raises(Refused, match="320 x 240 px"):
        make_detector(name).detect(0, colour, None, source.intrinsics)
    depth = np.zeros((240, 320), np.float32)
    with pytest.raises(Refused, match="depth image"):
        make_detector(name).detect(0, np.zeros((480, 640, 3), np.uint8), depth, source.intrinsics)


def test_unknown_names_are_refused() -> None:
    with pytest.raises(Refused, match="contrast"):
        make_detector("magic")
    with pytest.raises(Refused, match="blue"):
        make_detector("contrast", "plaid")
    with pytest.raises(Refused, match="hue"):
        make_detector("histogram", "black")


@pytest.mark.parametrize("name", ["thesis25", "fingertips5", "finger_thumb8"])
@pytest.mark.parametrize("detector", DETECTORS)
def test_every_protocol_of_paper_markers_is_seen(detector: str, name: str) -> None:
    protocol = load_protocol(name)
    frame = virtual_camera("open_close", "left", 6.0, protocol, seed=8).frame(6)
    finds = make_detector(detector, protocol_colour(protocol))
    seen = finds.detect(0, frame.colour_bgr, frame.depth_m, frame.intrinsics)
    assert len(protocol.names) - 2 <= len(seen) <= len(protocol.names)


def test_the_colour_of_a_protocol_is_one_that_is_known() -> None:
    paper = load_protocol("fingertips5")
    assert protocol_colour(paper) == named_colour("blue")
    with pytest.raises(Refused, match="without a colour"):
        protocol_colour(load_protocol("mocap13"))
    first, *rest = paper.markers
    for colour, word in (("red", "blue, red"), ("plaid", "of colours")):
        with pytest.raises(Refused, match=word):
            protocol_colour(replace(paper, markers=(replace(first, colour=colour), *rest)))
