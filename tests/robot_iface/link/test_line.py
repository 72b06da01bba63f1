"""The line between a run and its app takes bounded time and memory, and never mistakes noise for an order."""

from __future__ import annotations

import socket
import struct
from collections.abc import Iterator
from dataclasses import fields
from typing import Any

import numpy as np
import pytest

from robot_iface.link import SharedPage, Wire, line
from robot_iface.link.codec import decode, encode
from robot_iface.link.line import MAX_ORDERS_A_LOOK, RunLine
from robot_iface.link.messages import ORDERS, Ready
from robot_iface.loop import SimulatedClock
from robot_iface.runtime import Advance, LiveSample, Pause, Reverse, SetSpeed
from robot_iface.types import SafetyState, TickBlock

PERIOD_NS = 1_000_000


class LateClock(SimulatedClock):
    """Simulated time that has something to tell about lateness."""

    def late_ns(self, percentile: float) -> int:
        return round(1000 * percentile)

    @property
    def overruns(self) -> int:
        return 4


class Ends:
    def __init__(self, *, queued: bool = True) -> None:
        ours, self.app = socket.socketpair()
        self.page = SharedPage()
        self.wire = Wire(ours)
        self.line = RunLine(self.wire, self.page, LateClock(PERIOD_NS, lambda: None), queued=queued)

    def send(self, *messages: Any) -> None:
        for message in messages:
            content = encode(message)
            self.app.send(struct.pack("<I", len(content)) + content)

    def look(self, t_ns: int) -> list[Any]:
        orders = []
        while (order := self.line.take(t_ns)) is not None:
            orders.append(order)
        return orders


@pytest.fixture
def ends() -> Iterator[Ends]:
    ends = Ends()
    yield ends
    ends.wire.close()
    ends.app.close()
    ends.page.close()


def test_every_order_comes_through_in_its_order(ends: Ends) -> None:
    sent = [kind(0.5) if kind is SetSpeed else kind() for kind in ORDERS]
    assert {Reverse, Advance} <= set(ORDERS)
    ends.send(*sent)
    assert ends.look(0) == sent


def test_a_look_takes_few_orders_however_many_there_are(ends: Ends) -> None:
    speeds = [SetSpeed(0.1 + index / 1000) for index in range(5 * MAX_ORDERS_A_LOOK)]
    ends.send(*speeds)
    found = []
    for tick in range(5):
        orders = ends.look(tick * PERIOD_NS)
        assert len(orders) == MAX_ORDERS_A_LOOK
        assert ends.line.take(tick * PERIOD_NS) is None
        found.extend(orders)
    assert found == speeds
    assert not ends.page.pressed()


@pytest.mark.parametrize(
    "noise",
    [
        struct.pack("<I", 20) + bytes(range(20)),
        struct.pack("<I", 2**32 - 1),
        struct.pack("<I", line.MAX_ORDER_BYTES + 1),
        struct.pack("<I", 0),
    ],
    ids=["garbage", "giant", "too long", "empty"],
)
def test_noise_is_braked_for(noise: bytes, ends: Ends, capsys: pytest.CaptureFixture[str]) -> None:
    ends.app.send(noise)
    ends.send(Pause())
    assert ends.look(0) == []
    assert ends.page.pressed()
    assert "but must be" in capsys.readouterr().err
    assert ends.look(PERIOD_NS) == [], "it listens on"


def test_a_speed_out_of_bounds_is_noise(ends: Ends) -> None:
    content = encode(SetSpeed(0.5)).replace(struct.pack(">d", 0.5), struct.pack(">d", float("nan")))
    ends.app.send(struct.pack("<I", len(content)) + content)
    assert ends.look(0) == []
    assert ends.page.pressed()


def test_a_message_that_is_no_order_is_passed_over(ends: Ends) -> None:
    ends.send(Ready(), Pause())
    assert ends.look(0) == []
    assert ends.look(1) == [Pause()]
    assert not ends.page.pressed()


def test_an_app_that_is_gone_is_braked_for(ends: Ends) -> None:
    ends.app.close()
    assert ends.look(0) == []
    assert ends.page.pressed()


def test_an_app_that_never_reads_is_braked_for_before_memory_runs_out(
    ends: Ends, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(line, "MAX_UNSENT_BYTES", 1_000_000)
    rows = np.zeros((50, 12))
    said = 0
    while not ends.page.pressed():
        ends.line.say(block_of(rows))
        said += 1
        assert said < 1000
    assert said > 10


def block_of(rows: Any) -> Any:
    columns = {"t_ns": np.zeros(50, np.int64), "safety_state": np.zeros(50, np.uint8)}
    columns |= {"path_s": np.zeros(50), "path_speed": np.zeros(50)}
    return TickBlock(**{entry.name: columns.get(entry.name, rows) for entry in fields(TickBlock)})


def test_lateness_is_shown_beside_the_sample(ends: Ends) -> None:
    rows = np.zeros(12)
    ends.line.publish(LiveSample(9, rows, rows, rows, 0.0, 0.0, 0, "move", "", SafetyState.ACTIVE, rows))
    shown = ends.page.read_live()
    assert (shown.t_ns, shown.late_p99_ns, shown.overruns) == (9, 99_000, 4)


def test_what_is_said_arrives(ends: Ends) -> None:
    ends.line.say(Ready())
    ends.line.finish()
    length = struct.unpack("<I", ends.app.recv(4))[0]
    assert decode(ends.app.recv(length)) == Ready()
