"""Unplugging, replugging, leases and clocks, on simulated time."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from itertools import islice
from pathlib import Path
from types import TracebackType

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rehab_app.cameras import Frame, Outage, Reconnecting
from rehab_app.cameras.device_clock import DeviceClock
from rehab_app.cameras.lease import CameraLease
from rehab_app.cameras.lost import CameraLost, absent, closed
from rehab_app.cameras.pairing import Image, Pairing
from rehab_app.cameras.reconnecting import Clock
from rehab_app.geometry.pinhole import Intrinsics
from sessions.errors import Refused

PERIOD_NS = 33_333_333
LENS = Intrinsics(10.0, 10.0, 3.5, 2.5, 8, 6)


class World:
    """A clock, and a cable that is pulled between two times."""

    def __init__(self, pulled_ns: tuple[int, int]) -> None:
        self.now_ns = 1_000_000_000
        self.pulled_ns = pulled_ns
        self.opened = 0
        self.lens = LENS

    @property
    def plugged(self) -> bool:
        return not self.pulled_ns[0] <= self.now_ns < self.pulled_ns[1]

    def clock(self) -> Clock:
        return Clock(lambda: self.now_ns, self.sleep)

    def sleep(self, seconds: float) -> None:
        self.now_ns += round(1e9 * seconds)


class Cable:
    """A camera at the end of that cable."""

    name = "cable"
    has_depth = False
    rate_hz = 30.0

    def __init__(self, world: World) -> None:
        self._world = world
        self._open = False

    @property
    def intrinsics(self) -> Intrinsics:
        return self._world.lens

    def __enter__(self) -> Cable:
        if not self._world.plugged:
            raise absent("camera cable")
        self._open = True
        self._world.opened += 1
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._open = False

    def frames(self) -> Iterator[Frame]:
        if not self._open:
            raise closed()
        while self._open:
            self._world.now_ns += PERIOD_NS
            if not self._world.plugged:
                raise CameraLost("The cable was pulled.")
            yield Frame(self._world.now_ns, np.zeros((6, 8, 3), np.uint8), None, self.intrinsics)


def test_every_capture_is_either_seen_or_counted() -> None:
    world = World((2_000_000_000, 6_000_000_000))
    with Reconnecting(lambda: Cable(world), clock=world.clock()) as camera:
        captures = camera.frames()
        met = [next(captures) for _ in range(200)]
    frames = [capture for capture in met if isinstance(capture, Frame)]
    outages = [capture for capture in met if isinstance(capture, Outage)]
    spaced = np.diff([outage.t_ns for outage in outages])
    assert len(outages) == 8
    assert spaced.tolist() == [500_000_000] * 7
    assert {outage.reason for outage in outages} == {"The cable was pulled."}
    periods = np.rint(np.diff([frame.t_capture_ns for frame in frames]) / PERIOD_NS).astype(int)
    assert [frame.dropped for frame in frames[1:]] == (periods - 1).tolist()
    assert sum(frame.dropped for frame in frames) >= 4 * 29
    assert world.opened == 2


def test_it_may_be_closed_while_it_waits() -> None:
    world = World((1_500_000_000, 2**62))
    camera = Reconnecting(lambda: Cable(world), clock=world.clock())
    with camera:
        for capture in camera.frames():
            if isinstance(capture, Outage):
                break
    with pytest.raises(Refused, match="open it"):
        next(camera.frames())


def test_an_absent_camera_is_refused_at_once_and_its_lease_given_back(tmp_path: Path) -> None:
    world = World((0, 2**62))
    lease = CameraLease("cable:0", tmp_path)
    with pytest.raises(Refused, match="not found"):
        Reconnecting(lambda: Cable(world), lease, world.clock()).__enter__()
    assert not lease.is_taken


def test_another_camera_in_its_place_is_refused() -> None:
    world = World((2_000_000_000, 3_000_000_000))
    with Reconnecting(lambda: Cable(world), clock=world.clock()) as camera:
        captures = camera.frames()
        while isinstance(next(captures), Frame):
            continue
        world.lens = Intrinsics(10.0, 10.0, 7.5, 5.5, 16, 12)
        with pytest.raises(Refused, match="16 x 12 px"):
            list(islice(captures, 20))


def test_a_camera_is_leased_once_also_across_processes(tmp_path: Path) -> None:
    world = World((2**62, 2**62))
    one, two = (
        Reconnecting(lambda: Cable(world), CameraLease("cable:0", tmp_path), world.clock()) for _ in range(2)
    )
    program = (
        "import sys; from pathlib import Path; from rehab_app.cameras.lease import CameraLease;"
        "sys.exit(3 if CameraLease('cable:0', Path(sys.argv[1])).is_taken else 0)"
    )
    with one:
        with pytest.raises(Refused, match="in use by another program"):
            two.__enter__()
        done = subprocess.run([sys.executable, "-c", program, str(tmp_path)], check=False, timeout=60)
        assert done.returncode == 3
    assert not CameraLease("cable:0", tmp_path).is_taken
    with two:
        assert CameraLease("cable:0", tmp_path).is_taken


@given(st.integers(0, 2**60), st.integers(0, 2**30))
def test_the_clock_of_a_device_keeps_spacing_and_never_tells_the_future(zero_ns: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    clock = DeviceClock()
    device = zero_ns + PERIOD_NS * np.arange(300)
    captured = 5_000_000_000 + (1.00003 * PERIOD_NS * np.arange(300)).astype(np.int64)  # 30 ppm apart
    arrived = captured + rng.exponential(8e6, 300).astype(np.int64)
    arrived[0] += 100_000_000  # the first image comes late
    told = np.array([clock.monotonic_ns(int(d), int(a)) for d, a in zip(device, arrived, strict=True)])
    assert (np.rint(np.diff(told) / PERIOD_NS) == 1).all()
    assert np.abs(told[60:] - captured[60:]).max() < 8e6
    assert (told[60:] <= arrived[60:]).all()


@pytest.mark.parametrize(
    "met",
    [
        ((10**12, 100), (10**12 + 50, 150), (5, 160), (60, 215)),
        ((0, 1000), (50, 1001), (5, 1002), (60, 1057)),  # what came late was told too late
    ],
)
def test_a_device_that_starts_anew_stays_in_order(met: tuple[tuple[int, int], ...]) -> None:
    clock = DeviceClock()
    times = [clock.monotonic_ns(device_ns, now_ns) for device_ns, now_ns in met]
    assert times == sorted(set(times))


def image(t_ms: int) -> Image:
    return Image(0, t_ms * 1_000_000, np.empty(0))


def test_images_of_one_capture_are_paired_by_time() -> None:
    pairing = Pairing(16_000_000)
    assert pairing.add("depth", image(0)) is None
    assert pairing.add("colour", image(33)) is None  # the depth belongs to the capture before
    assert pairing.add("depth", image(34)) is not None
    assert pairing.add("depth", image(67)) is None
    colour, depth = pairing.add("colour", image(66)) or (None, None)
    assert (colour, depth) != (None, None)


def test_streams_without_a_common_clock_are_paired_by_arrival() -> None:
    pairing = Pairing(16_000_000)
    pairs = 0
    for index in range(40):
        for kind, shift in (("colour", 0), ("depth", 500)):
            pairs += pairing.add(kind, image(33 * index + shift)) is not None
    assert pairs >= 33
