"""The motion process's side of the link: one request at a time, one run at a time."""

from __future__ import annotations

import gc
import os
from collections.abc import Callable, Generator
from contextlib import contextmanager
from typing import Any

from robot_iface.errors import Refused
from robot_iface.link.codec import decode, encode
from robot_iface.link.messages import Cleared, Ready, Refusal, Rehearse, Start, Started
from robot_iface.link.page import SharedPage
from robot_iface.link.wire import Wire, WireClosed
from robot_iface.loop import request_realtime_priority
from robot_iface.rehearsal import rehearse
from robot_iface.runtime import (
    LiveSample,
    Message,
    Order,
    Pain,
    Pause,
    Reset,
    Resume,
    Rig,
    SetSpeed,
    Surroundings,
    run,
)
from robot_iface.types import Plan, RunEnd, SafetyState

MAX_UNSENT_BYTES = 64 * 1024 * 1024
_ORDERS = (Pause, Resume, SetSpeed, Pain, Reset)
_LATCHING = (SafetyState.HOLD, SafetyState.COMPLIANT, SafetyState.CAT1, SafetyState.CAT0)


def serve(wire: Wire, page: SharedPage, open_rig: Callable[[Plan], Rig]) -> None:
    """Answer the app until it is gone.

    Args:
        wire: Link to the app.
        page: Memory shared with it.
        open_rig: Chooses device and clock for a plan; raises Refused where there is none.
    """
    server = _Server(wire, page, open_rig)
    try:
        wire.send(encode(Ready()))
        while True:
            server.answer(wire.receive(None) or b"")
    except WireClosed:
        return


class _Server:
    """State between requests: whether the last run ended latched."""

    def __init__(self, wire: Wire, page: SharedPage, open_rig: Callable[[Plan], Rig]) -> None:
        self._wire = wire
        self._page = page
        self._open_rig = open_rig
        self._latched = False

    def answer(self, content: bytes) -> None:
        """Do what one message asks, or say why not."""
        try:
            request = decode(content)
            match request:
                case Rehearse():
                    self._wire.send(encode(rehearse(request.plan)))
                case Start():
                    self._run(request)
                case Reset():
                    self._page.clear_stop()
                    self._latched = False
                    self._wire.send(encode(Cleared()))
                case _:
                    pass  # an order for a run that has just ended
        except Refused as refused:
            answer = Refusal(refused.thing, refused.value, refused.bound, refused.remedy)
            self._wire.send(encode(answer))

    def _run(self, request: Start) -> None:
        if self._latched or self._page.pressed():
            raise Refused(
                "the motion process",
                "stopped",
                "reset",
                "look at the patient, reset the stop and start again",
            )
        line = _RunLine(self._wire, self._page, request.plan.realtime)
        around = Surroundings(self._page, line.sink, line, line, lambda: line.say(Started()))
        with _undisturbed(request.plan.realtime):
            end = run(request.plan, request.certificate, self._open_rig(request.plan), around)
        self._latched = end.state in _LATCHING
        line.finish()


@contextmanager
def _undisturbed(realtime: bool) -> Generator[None, None, None]:
    """No garbage collection, whose pause would be a late tick; in real time also real-time priority."""
    gc.collect()
    gc.disable()
    if realtime:
        request_realtime_priority()
    try:
        yield
    finally:
        if realtime:  # nothing but the loop may run ahead of everybody else
            os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
        gc.enable()


class _RunLine:
    """Everything that joins one run to the app: messages out, orders in, telemetry, heartbeat."""

    def __init__(self, wire: Wire, page: SharedPage, realtime: bool) -> None:
        self._wire = wire
        self._page = page
        self._realtime = realtime
        self._gone = False

    def say(self, message: Any) -> None:
        """Pass a message on; in real time it is queued, so that a slow app never makes a tick wait."""
        if self._gone:
            return
        try:
            self._wire.queue(encode(message))
            if not self._realtime:
                self._wire.drain()
            elif self._wire.unsent_bytes > MAX_UNSENT_BYTES:
                self._lose()
        except WireClosed:
            self._lose()

    def sink(self, message: Message | RunEnd) -> None:
        """Receive a run's messages."""
        self.say(message)

    def take(self, t_ns: int) -> Order | None:
        """The next order of the app, or None."""
        if self._gone:
            return None
        try:
            content = self._wire.receive(0.0)
            self._wire.push()
        except WireClosed:
            self._lose()
            return None
        if content is None:
            return None
        order = decode(content)
        return order if isinstance(order, _ORDERS) else None

    def heartbeat_age_ns(self) -> int:
        """How long the app has been silent."""
        return self._page.beat_age_ns()

    def operator_age_ns(self) -> int:
        """How long the operator's page has been silent, 0 where none has ever shown itself in this run."""
        return self._page.operator_age_ns()

    def publish(self, sample: LiveSample) -> None:
        """Show telemetry."""
        self._page.write_live(sample)

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
        """The app is gone, or has read nothing for a minute: brake, as if it had pressed stop."""
        self._gone = True
        self._page.press_stop()
