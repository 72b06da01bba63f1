"""An app that is killed, frozen, floods the link or talks nonsense does the patient no harm."""

from __future__ import annotations

import os
import random
import select
import signal
import struct
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from robot_iface.errors import Refused
from robot_iface.link import MotionClient, SharedPage
from robot_iface.link.codec import encode
from robot_iface.runtime import LiveSample, Pain, Resume, SetSpeed
from robot_iface.types import Plan, RunEnd, SafetyEvent, SafetyState

MakePlan = Callable[..., Plan]
HEARTBEAT_NS = 250_000_000
DEADLINE_NS = 252_000_000
PATIENCE_S = 30.0
SHARED = Path(__file__).parents[1]


class RoughApp:
    """An app in a process of its own, and its motion process seen through the page that the two share."""

    def __init__(self) -> None:
        script = [sys.executable, str(Path(__file__).with_name("rough_app.py")), str(SHARED)]
        self.app = subprocess.Popen(script, stdout=subprocess.PIPE, text=True)
        assert self.app.stdout is not None
        line = self.app.stdout.readline()
        if not line.strip().isdigit():
            self._end_app()
            raise AssertionError(f"the hand never moved: {line}")
        pid = int(line)
        self.motion = os.pidfd_open(pid)
        page = Path(f"/proc/{pid}/cmdline").read_text().split("\0")[-2]
        self.page = SharedPage(os.open(f"/proc/{pid}/fd/{page}", os.O_RDWR))

    def wait_for(self, state: SafetyState) -> LiveSample:
        end_s = time.monotonic() + PATIENCE_S
        while time.monotonic() < end_s:
            sample = self.page.read_live()
            if sample.safety_state is state and self.page.latched_t_ns:
                return sample
            time.sleep(0.001)
        raise AssertionError(f"not {state.name}, but {self.page.read_live()}")

    def motion_ended(self) -> bool:
        return bool(select.select([self.motion], [], [], PATIENCE_S)[0])

    def _end_app(self) -> None:
        self.app.kill()
        self.app.wait()
        assert self.app.stdout is not None
        self.app.stdout.close()

    def close(self) -> None:
        self._end_app()
        assert self.motion_ended(), "the motion process outlived its app"
        os.close(self.motion)
        self.page.close()


@pytest.fixture
def rough() -> Iterator[RoughApp]:
    app = RoughApp()
    yield app
    app.close()


def test_a_killed_app_is_braked_for_in_time_and_power_is_cut(rough: RoughApp) -> None:
    killed_ns = time.monotonic_ns()
    rough.app.kill()
    sample = rough.wait_for(SafetyState.CAT1)
    assert rough.page.latched_t_ns - killed_ns <= DEADLINE_NS + sample.late_p99_ns
    assert rough.motion_ended(), "it brakes for ever"
    last = rough.page.read_live()
    assert last.safety_state is SafetyState.CAT1
    assert abs(last.path_speed) == 0.0


def test_a_frozen_app_is_braked_for_in_time(rough: RoughApp) -> None:
    rough.app.send_signal(signal.SIGSTOP)
    sample = rough.wait_for(SafetyState.CAT1)
    silent_ns = rough.page.latched_t_ns - (time.monotonic_ns() - rough.page.beat_age_ns())
    assert HEARTBEAT_NS < silent_ns + 2_000_000
    assert silent_ns <= DEADLINE_NS + 2 * max(sample.late_p99_ns, 1_000_000)
    rough.app.send_signal(signal.SIGCONT)
    assert rough.app.stdout is not None
    assert rough.app.stdout.readline() == "heartbeat-lost\n"


def start_moving(client: MotionClient, plan: Plan) -> MotionClient:
    """A run in real time that moves, and goes on for minutes if nobody stops it."""
    client.start(plan, client.rehearse(plan))
    for _ in client.messages():
        if client.live().phase == "move":
            break
    return client


@pytest.fixture
def plan(make_plan: MakePlan, fist: Any) -> Plan:
    return make_plan(path=fist(1.0, 6.0, 20.0), realtime=True, repetitions=200)


@pytest.fixture(scope="module")
def lasting() -> Iterator[MotionClient]:
    """A motion process that outlives a test, for those that do it no lasting harm."""
    with MotionClient() as client:
        yield client


@pytest.fixture
def moving(lasting: MotionClient, plan: Plan) -> Iterator[MotionClient]:
    """A run that moves in the lasting process; stopped and reset after the test."""
    yield start_moving(lasting, plan)
    lasting.press_stop()
    list(lasting.messages())
    lasting.reset()


class Reader:
    """Reads a run's messages in a thread, as an app does, and thereby beats."""

    def __init__(self, client: MotionClient) -> None:
        self.messages: list[Any] = []
        self.refused = ""
        self._client = client
        self._thread = threading.Thread(target=self._read)
        self._thread.start()

    def _read(self) -> None:
        try:
            self.messages.extend(self._client.messages())
        except Refused as refused:
            self.refused = str(refused)

    def end(self) -> RunEnd | None:
        self._thread.join(PATIENCE_S)
        assert not self._thread.is_alive(), "the run never ended"
        return next((message for message in self.messages if isinstance(message, RunEnd)), None)

    def causes(self) -> list[str]:
        return [message.cause for message in self.messages if isinstance(message, SafetyEvent)]


def progress(client: MotionClient, seconds: float, act: Callable[[], None]) -> float:
    """Loop time that passes in some wall time, s per s, while something is done over and over."""
    start_ns, start_s = client.live().t_ns, time.monotonic()
    while time.monotonic() < start_s + seconds:
        act()
    return (client.live().t_ns - start_ns) * 1e-9 / (time.monotonic() - start_s)


def resident_bytes(pid: int) -> int:
    return int(Path(f"/proc/{pid}/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def raw(client: MotionClient, content: bytes) -> None:
    """Bytes on the link as they are; what it does not take now is dropped."""
    try:
        client._wire._end.send(content)
    except BlockingIOError:
        time.sleep(0.0005)


def framed(content: bytes) -> bytes:
    return struct.pack("<I", len(content)) + content


def test_a_flood_of_orders_costs_no_tick_and_no_memory(moving: MotionClient) -> None:
    reader = Reader(moving)
    quiet = progress(moving, 1.0, lambda: time.sleep(0.01))
    before = resident_bytes(moving.pid)
    order = framed(encode(Resume()))
    flooded = progress(moving, 1.5, lambda: raw(moving, 500 * order))
    assert flooded >= 0.5 * quiet, "the loop fell behind"
    assert resident_bytes(moving.pid) - before < 32 * 2**20
    assert reader.causes() == []
    moving.press_stop()
    end = reader.end()
    assert end is not None
    assert end.state is SafetyState.CAT1


def test_the_stop_acts_while_the_link_is_jammed_both_ways(moving: MotionClient) -> None:
    order = framed(encode(SetSpeed(0.3)))

    def jam() -> None:
        raw(moving, 500 * order)
        moving.beat()

    progress(moving, 1.0, jam)  # nothing is read: the motion process cannot send any more either
    pressed_ns = time.monotonic_ns()
    moving.press_stop()
    while moving.stop_latency_ns() is None and time.monotonic_ns() < pressed_ns + 10**10:
        jam()
    latency_ns = moving.stop_latency_ns()
    assert latency_ns is not None
    assert moving.live().safety_state is SafetyState.CAT1
    assert latency_ns <= DEADLINE_NS


@pytest.mark.parametrize(
    "nonsense",
    [framed(random.Random(7).randbytes(300)), struct.pack("<I", 5_000) + bytes(100)],
    ids=["garbage", "longer than any order"],
)
def test_nonsense_on_the_link_brakes_and_ends_the_process(nonsense: bytes, plan: Plan) -> None:
    with MotionClient() as client:
        reader = Reader(start_moving(client, plan))
        raw(client, nonsense)
        assert reader.end() is None
        assert "motion process is gone" in reader.refused
        assert "but must be" in reader.refused, "it does not say why"
        assert client.live().safety_state is SafetyState.CAT1
        assert client.stop_latency_ns() is not None


def test_half_a_message_is_waited_for_and_the_rest_still_counts(moving: MotionClient) -> None:
    reader = Reader(moving)
    order = framed(encode(Pain()))
    raw(moving, order[:7])
    assert progress(moving, 0.3, lambda: time.sleep(0.01)) > 0.0
    assert reader.causes() == []
    raw(moving, order[7:])
    while not reader.causes():
        time.sleep(0.01)
    moving.press_stop()
    end = reader.end()
    assert end is not None
    assert reader.causes()[0] == "pain"
    assert end.state is SafetyState.CAT1
    assert end.late_p99_ns > 0
