"""What joins one run to the app: messages out, orders in, telemetry, signs of life."""

from __future__ import annotations

import sys
from dataclasses import replace
from typing import Any

from robot_iface.errors import Refused
from robot_iface.link.codec import decode, encode
from robot_iface.link.messages import ORDERS
from robot_iface.link.page import SharedPage
from robot_iface.link.wire import Wire, WireClosed
from robot_iface.runtime import LiveSample, LoopClock, Message, Order
from robot_iface.types import RunEnd

MAX_UNSENT_BYTES = 64 * 1024 * 1024
MAX_ORDER_BYTES = 4096
"""No order is longer; a longer message in mid-run would cost a tick to read."""
MAX_ORDERS_A_LOOK = 8
"""A look for orders, every few ticks, takes no more, so that a flood of them costs no tick its deadline."""


class RunLine:
    """Everything that joins one run to the app. Nothing here waits in real time.

    However fast, slow or mad the app is, a look for orders costs little and bounded time and memory; an app
    that is gone or cannot be understood is braked for, as if it had pressed stop.

    Args:
        wire: Link to the app.
        page: Memory shared with it.
        clock: Time of the loop, whose lateness is shown.
        queued: Whether messages wait in a queue rather than making a tick wait.
    """

    def __init__(self, wire: Wire, page: SharedPage, clock: LoopClock, *, queued: bool) -> None:
        self._wire = wire
        self._page = page
        self._clock = clock
        self._queued = queued
        self._look_ns = -1
        self._looks_left = 0
        self._gone = False

    def say(self, message: Any) -> None:
        """Pass a message on; in real time it is queued, so that a slow app never makes a tick wait."""
        if self._gone:
            return
        try:
            self._wire.queue(encode(message))
            if not self._queued:
                self._wire.drain()
            elif self._wire.unsent_bytes > MAX_UNSENT_BYTES:
                self._lose()
        except WireClosed:
            self._lose()

    def sink(self, message: Message | RunEnd) -> None:
        """Receive a run's messages."""
        self.say(message)

    def take(self, t_ns: int) -> Order | None:
        """The next order of the app, or None. What cannot be read is no order, but the loss of the app."""
        if t_ns != self._look_ns:
            self._look_ns, self._looks_left = t_ns, MAX_ORDERS_A_LOOK
        if self._gone or not self._looks_left:
            return None
        self._looks_left -= 1
        try:
            content = self._wire.receive(0.0, MAX_ORDER_BYTES)
            self._wire.push()
            order = None if content is None else decode(content)
        except WireClosed:
            self._lose()
            return None
        except Refused as refused:
            sys.stderr.write(f"{refused}\n")  # the app shows it as this process's last words
            self._lose()
            return None
        return order if isinstance(order, ORDERS) else None

    def heartbeat_age_ns(self) -> int:
        """How long the app has been silent."""
        return self._page.beat_age_ns()

    def operator_age_ns(self) -> int:
        """How long the operator's page has been silent, 0 where none has ever shown itself in this run."""
        return self._page.operator_age_ns()

    def publish(self, sample: LiveSample) -> None:
        """Show telemetry, and how well the loop keeps its time."""
        late_ns, overruns = self._clock.late_ns(99.0), self._clock.overruns
        self._page.write_live(replace(sample, late_p99_ns=late_ns, overruns=overruns))

    def latched(self) -> None:
        """Note when the loop acted on the stop word."""
        self._page.latch()

    def finish(self) -> None:
        """Send what is still queued.

        Raises:
            WireClosed: The app is gone.
        """
        if self._gone:
            raise WireClosed
        self._wire.drain()

    def _lose(self) -> None:
        """The app is gone, talks nonsense, or reads nothing: brake, as if it had pressed stop."""
        self._gone = True
        self._page.press_stop()
