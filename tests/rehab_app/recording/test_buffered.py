"""A camera that is read ahead: nothing is lost while there is room, what does not fit is counted."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator

import numpy as np
import pytest

from rehab_app.cameras import Capture, Frame, Outage
from rehab_app.geometry.pinhole import KINECT
from rehab_app.recording.buffered import Buffered
from sessions.errors import Refused

PICTURE = np.zeros((480, 640, 3), np.uint8)


class Source:
    """Gives captures as fast as they are asked for, then ends, fails, or waits."""

    name = "source"
    intrinsics = KINECT
    rate_hz = 30.0
    has_depth = False

    def __init__(self, count: int, then: str = "end") -> None:
        self._count = count
        self._then = then
        self.all_given = threading.Event()
        self.reading = False
        self.closed_under_a_read = False

    def __enter__(self) -> Source:
        return self

    def __exit__(self, *_: object) -> None:
        self.closed_under_a_read = self.reading

    def frames(self) -> Iterator[Capture]:
        self.reading = True
        for index in range(self._count):
            yield Frame(index, PICTURE, None, KINECT)
        self.all_given.set()
        if self._then == "fail":
            raise Refused("camera", "broken", "whole", "replace it")
        index = self._count
        while self._then == "wait":
            time.sleep(0.01)
            index += 1
            yield Outage(index, "unplugged")
        self.reading = False


def taken(camera: Buffered, most: int) -> list[Capture]:
    found: list[Capture] = []
    for capture in camera.frames():
        found.append(capture)
        if len(found) == most:
            break
    return found


def test_what_fits_is_not_lost_however_slow_the_reader() -> None:
    source = Source(50)
    with Buffered(source, most=60) as camera:
        assert source.all_given.wait(5.0)
        found = list(camera.frames())
    assert [one.t_capture_ns for one in found if isinstance(one, Frame)] == list(range(50))
    assert all(one.dropped == 0 for one in found if isinstance(one, Frame))
    assert (camera.name, camera.rate_hz, camera.has_depth) == ("source", 30.0, False)


def test_what_does_not_fit_is_dropped_and_counted() -> None:
    class Paced(Source):
        def frames(self) -> Iterator[Capture]:
            yield from (Frame(index, PICTURE, None, KINECT) for index in range(20))
            self.all_given.set()
            room.wait(5.0)
            yield Frame(20, PICTURE, None, KINECT, dropped=2)

    room, source = threading.Event(), Paced(0)
    with Buffered(source, most=8) as camera:
        assert source.all_given.wait(5.0)
        found = taken(camera, 8)
        room.set()
        found += list(camera.frames())
    frames = [one for one in found if isinstance(one, Frame)]
    assert [one.t_capture_ns for one in frames] == [*range(8), 20]
    assert frames[-1].dropped == 12 + 2


def test_a_refusal_of_the_camera_comes_out_after_its_captures() -> None:
    with Buffered(Source(3, "fail")) as camera:
        found: list[Capture] = []
        with pytest.raises(Refused, match="replace it"):
            found.extend(camera.frames())
    assert len(found) == 3
    with pytest.raises(Refused, match="open it"):
        next(camera.frames())


def test_leaving_ends_the_reader_before_the_camera_is_closed() -> None:
    source = Source(100, "wait")
    with Buffered(source, most=5) as camera:
        assert len(taken(camera, 3)) == 3
    assert camera._reading is not None
    assert camera._reading.done()
