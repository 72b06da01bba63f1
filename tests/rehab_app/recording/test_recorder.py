"""What befalls a recording lies in its file: outages, lost captures, bad pictures; images if consented."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from rehab_app.cameras import FACING, Capture, Frame, Outage, virtual_camera, virtual_cameras
from rehab_app.cameras.recorded import RecordedCamera
from rehab_app.hand.protocol import load_protocol
from rehab_app.recording.behind import Behind
from rehab_app.recording.live_pose import LivePose
from rehab_app.recording.quality import Quality
from rehab_app.recording.recorder import TakeOrder, record_take
from rehab_app.tracking import TrackedHand
from rehab_app.tracking.description import unknown
from sessions.errors import Refused
from sessions.records import Event, Status
from sessions.records.topics import EVENTS, MARKERS
from sessions.store import SessionReader

PROTOCOL = load_protocol("thesis25")
UNPLUGGED = "The camera virtual-camera was unplugged: plug it in again."


class Troubled:
    """The virtual camera with an outage, lost captures and black pictures."""

    name = "virtual-camera"
    has_depth = True
    rate_hz = 30.0

    def __init__(self, outage_at: int = -1, black: range = range(0)) -> None:
        self._inner = virtual_camera("still", "right", 5.0, PROTOCOL, seed=2)
        self.intrinsics = self._inner.intrinsics
        self._outage_at = outage_at
        self._black = black

    def __enter__(self) -> Troubled:
        self._inner.__enter__()
        return self

    def __exit__(self, *_: object) -> None:
        self._inner.__exit__(None, None, None)

    def frames(self) -> Iterator[Capture]:
        late_ns = 0
        for index, frame in enumerate(self._inner.frames()):
            if not isinstance(frame, Frame):
                continue
            dropped = 0
            if index == self._outage_at:
                yield from (Outage(frame.t_capture_ns + part, UNPLUGGED) for part in range(3))
                late_ns, dropped = 500_000_000, 15
            image = np.zeros_like(frame.colour_bgr) if index in self._black else frame.colour_bgr
            yield replace(frame, t_capture_ns=frame.t_capture_ns + late_ns, colour_bgr=image, dropped=dropped)


def order(folder: Path, seconds: float = 2.4, *, consent: bool = False) -> TakeOrder:
    return TakeOrder(folder / "take.mcap", "right", "still", seconds, "0", consent_images=consent)


def events(path: Path) -> list[Event]:
    with SessionReader(path) as reader:
        return list(reader.records(EVENTS))


def test_an_outage_is_shown_noted_and_survived(tmp_path: Path) -> None:
    told: list[Outage] = []
    take = record_take(Troubled(outage_at=45), PROTOCOL, order(tmp_path), on_outage=told.append)
    assert [one.reason for one in told] == [UNPLUGGED] * 3
    assert take.dropped == 15
    assert take.complaints == (UNPLUGGED,)
    noted = events(take.path)
    assert [one.cause for one in noted] == ["outage", "camera-back", "captures-lost"]
    assert noted[0].text == UNPLUGGED
    with SessionReader(take.path) as reader:
        t_ns = reader.columns(MARKERS).t_ns
    assert np.diff(t_ns).max() == pytest.approx(500_000_000 + 1e9 / 30, rel=1e-3)
    assert take.measured_share > 0.9


def test_a_black_picture_is_said_and_noted_and_the_quality_falls(tmp_path: Path) -> None:
    seen: list[LivePose] = []
    take = record_take(Troubled(black=range(45, 72)), PROTOCOL, order(tmp_path), on_frame=seen.append)
    assert "black" in seen[50].trouble
    assert seen[44].trouble == ""
    assert seen[44].estimated + seen[44].lost < 0.1
    assert seen[70].estimated + seen[70].lost > 0.5
    assert "black" in take.complaints[0]
    assert "picture" in [one.cause for one in events(take.path)]
    assert take.measured_share < 0.8


def test_images_lie_in_the_take_with_consent_from_the_open_hand_on(tmp_path: Path) -> None:
    take = record_take(Troubled(), PROTOCOL, order(tmp_path, 1.2, consent=True))
    played = RecordedCamera(take.path)
    with played:
        frames = [one for one in played.frames() if isinstance(one, Frame)]
    assert len(frames) == take.frames == 37
    truth = virtual_camera("still", "right", 5.0, PROTOCOL, seed=2)
    first = truth.frame(0)
    assert played.intrinsics == first.intrinsics
    depth = frames[0].depth_m
    assert depth is not None
    assert first.depth_m is not None
    assert np.abs(depth - first.depth_m).max() < 0.001
    assert np.abs(frames[0].colour_bgr.astype(int) - first.colour_bgr).mean() < 3.0


def test_two_cameras_that_face_each_other_see_more_of_a_grasp(tmp_path: Path) -> None:
    shares: list[float] = []
    for views in ((FACING[0],), FACING):
        cameras = virtual_cameras("cylinder", "right", 4.0, PROTOCOL, level="hard", views=views, seed=6)
        wanted = replace(order(tmp_path, 4.0), path=tmp_path / f"{len(views)}.mcap")
        take = record_take(cameras, PROTOCOL, wanted, views=views)
        assert take.frames >= 115
        shares.append(take.measured_share)
    assert shares[1] > shares[0] + 0.02


def test_what_is_written_behind_comes_in_order_and_its_refusal_is_raised() -> None:
    gate, done = threading.Event(), list[int]()
    behind = Behind(most=3)

    def work(number: int) -> None:
        gate.wait(10.0)
        done.append(number)
        if number == 4:
            raise Refused("disk", "full", "free", "make space")

    gate.set()
    for number in range(4):
        behind.do(lambda number=number: work(number))
    behind.finish()
    assert done == [0, 1, 2, 3]
    behind.do(lambda: work(4))
    with pytest.raises(Refused, match="make space"):
        behind.finish()
    behind.close()


def test_what_failed_behind_is_raised_before_much_more_is_done() -> None:
    def fail() -> None:
        raise Refused("disk", "full", "free", "make space")

    def go_on() -> None:
        for _ in range(4):  # when more than three wait at the latest, the first is looked at
            behind.do(lambda: None)

    behind = Behind(most=3)
    behind.do(fail)
    with pytest.raises(Refused, match="make space"):
        go_on()
    behind.close()
    behind.close()


def tracked(t_ns: int, statuses: list[Status]) -> TrackedHand:
    hand = unknown(t_ns, len(statuses), "tracking")
    return replace(hand, markers=replace(hand.markers, status=np.array(statuses, dtype=np.uint8)))


def test_quality_counts_shares_gaps_and_the_last_second() -> None:
    quality = Quality()
    assert quality.lately() == (1.0, 0.0, 0.0)
    good, gap = [Status.MEASURED] * 4, [Status.MEASURED, Status.MEASURED, Status.ESTIMATED, Status.LOST]
    for index, row in enumerate([good, gap, gap, good, gap]):
        quality.add(tracked(index * 500_000_000, row))
    assert quality.frames == 5
    assert quality.gaps == 4
    assert quality.share(Status.MEASURED) == pytest.approx(14 / 20)
    assert quality.share(Status.LOST) == pytest.approx(3 / 20)
    assert quality.lately() == pytest.approx((1 / 8, 1 / 8, 6 / 8))
