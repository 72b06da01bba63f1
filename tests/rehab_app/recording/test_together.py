"""Captures of several cameras are put together by their time; an outage of one is handed on."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from rehab_app.cameras import Capture, Frame, Outage
from rehab_app.geometry.pinhole import KINECT
from rehab_app.recording.together import Instant, together

PERIOD_NS = 33_333_333
PICTURE = np.zeros((480, 640, 3), np.uint8)


class Played:
    """A camera that plays captures."""

    name = "played"
    intrinsics = KINECT
    rate_hz = 30.0
    has_depth = False

    def __init__(self, captures: Sequence[Capture]) -> None:
        self._captures = captures

    def __enter__(self) -> Played:
        return self

    def __exit__(self, *_: object) -> None:
        return

    def frames(self) -> Iterator[Capture]:
        yield from self._captures


def frame(t_ns: int, dropped: int = 0) -> Frame:
    return Frame(t_ns, PICTURE, None, KINECT, dropped)


def times(found: Sequence[Instant | Outage]) -> list[list[int | None]]:
    return [
        [None if one is None else one.t_capture_ns for one in instant.frames]
        for instant in found
        if isinstance(instant, Instant)
    ]


def test_one_camera_comes_through_as_it_is() -> None:
    captures = [frame(0), Outage(5, "gone"), frame(PERIOD_NS, 2)]
    found = list(together([Played(captures)]))
    assert [isinstance(one, Outage) for one in found] == [False, True, False]
    assert isinstance(found[2], Instant)
    assert found[2].dropped == 2


def test_frames_half_a_period_apart_belong_together() -> None:
    rng = np.random.default_rng(0)
    first = [index * PERIOD_NS for index in range(50)]
    jitter = rng.integers(-PERIOD_NS // 3, PERIOD_NS // 3, 50)
    second = [PERIOD_NS // 10 + at + int(late) for at, late in zip(first, jitter, strict=True)]
    found = list(together([Played([frame(t) for t in first]), Played([frame(t) for t in second])]))
    assert times(found) == [list(pair) for pair in zip(first, second, strict=True)]


def test_a_capture_that_one_camera_lost_comes_alone() -> None:
    first = [index * PERIOD_NS for index in range(6)]
    second = [t + 1000 for index, t in enumerate(first) if index != 3]
    found = list(together([Played([frame(t) for t in first]), Played([frame(t) for t in second])]))
    assert times(found)[3] == [first[3], None]
    assert len(found) == 6
    ahead = list(together([Played([frame(t) for t in second]), Played([frame(t) for t in first])]))
    assert times(ahead)[3] == [None, first[3]]
    alone = ahead[3]
    assert isinstance(alone, Instant)
    assert alone.camera == 1
    assert alone.shown.t_capture_ns == first[3]


def test_the_others_go_on_through_an_outage_and_after_an_end() -> None:
    first: list[Capture] = [frame(0), Outage(1, "unplugged"), Outage(2, "unplugged"), frame(4 * PERIOD_NS)]
    second = [frame(index * PERIOD_NS) for index in range(8)]
    found = list(together([Played(first), Played(second)]))
    assert sum(isinstance(one, Outage) for one in found) == 2
    assert [row[1] for row in times(found)] == [index * PERIOD_NS for index in range(8)]
    assert times(found)[4] == [4 * PERIOD_NS, 4 * PERIOD_NS]
    assert times(found)[5][0] is None
