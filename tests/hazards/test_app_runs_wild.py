"""Hazard: an app that has gone mad floods or garbles the link, and the stop or a tick of the loop is lost."""

from __future__ import annotations

import random
import socket
import struct
from typing import Any

from robot_iface.link import SharedPage, Wire
from robot_iface.link.codec import encode
from robot_iface.link.line import MAX_ORDERS_A_LOOK, RunLine
from robot_iface.loop import SimulatedClock
from robot_iface.runtime import Resume
from robot_iface.types import SafetyState

LOOK_EVERY_TICKS = 5


class WildApp:
    """A supervised hand whose loop looks for orders, at the other end of a link that the test abuses."""

    def __init__(self, rigid: Any) -> None:
        self.rig = rigid.Rig()
        self.period_ns = rigid.PERIOD_NS
        ours, self.end = socket.socketpair()
        self.end.setblocking(False)
        self.page = SharedPage()
        clock = SimulatedClock(rigid.PERIOD_NS, lambda: None)
        self.wire = Wire(ours)
        self.line = RunLine(self.wire, self.page, clock, queued=True)
        self.rig.go_active()

    def send(self, content: bytes) -> None:
        """What the link takes; the rest is lost."""
        try:
            self.end.send(content)
        except BlockingIOError:
            return

    def tick(self) -> int:
        """One cycle of the loop; returns how many orders it had to take."""
        t_ns, orders = self.rig.hand.tick * self.period_ns, 0
        if self.rig.hand.tick % LOOK_EVERY_TICKS == 0:
            while self.line.take(t_ns) is not None:
                orders += 1
        self.rig.button.down = self.page.pressed()
        self.rig.cycle()
        return orders

    def close(self) -> None:
        self.wire.close()
        self.end.close()
        self.page.close()


def test_a_flood_of_orders_neither_holds_up_a_tick_nor_the_stop(rigid: Any) -> None:
    app = WildApp(rigid)
    content = encode(Resume())
    flood = 1000 * (struct.pack("<I", len(content)) + content)
    taken = []
    for _ in range(500):
        app.send(flood)
        taken.append(app.tick())
    assert max(taken) == MAX_ORDERS_A_LOOK
    assert app.rig.supervisor.state is SafetyState.ACTIVE
    app.page.press_stop()
    app.send(flood)
    app.tick()
    assert app.rig.supervisor.state is SafetyState.CAT1
    assert app.rig.causes() == ["e-stop"]
    app.close()


def test_noise_on_the_link_is_the_loss_of_the_app(rigid: Any) -> None:
    noise = random.Random(3)
    for _ in range(20):
        app = WildApp(rigid)
        app.send(noise.randbytes(4096))
        for _ in range(LOOK_EVERY_TICKS):
            app.tick()
        assert app.rig.supervisor.state is SafetyState.CAT1
        app.rig.run(600)
        assert app.rig.hand.mode == "off"
        app.close()
