"""The motion process's side of the link: one request at a time, one run at a time."""

from __future__ import annotations

import gc
import os
from collections.abc import Callable, Generator
from contextlib import contextmanager, suppress

from robot_iface.errors import Refused
from robot_iface.link.codec import decode, encode
from robot_iface.link.line import RunLine
from robot_iface.link.messages import Cleared, Ready, Refusal, Rehearse, Start, Started
from robot_iface.link.page import SharedPage
from robot_iface.link.wire import Wire, WireClosed
from robot_iface.loop import request_realtime_priority
from robot_iface.rehearsal import rehearse
from robot_iface.runtime import Reset, Rig, Surroundings, run
from robot_iface.types import Plan, SafetyState

_LAST_WORDS_S = 1.0
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
    except Refused as refused:  # an impossible length: nothing that follows can be told from noise
        with suppress(WireClosed):
            wire.send(encode(_refusal(refused)), _LAST_WORDS_S)
    except WireClosed:
        return


def _refusal(refused: Refused) -> Refusal:
    return Refusal(refused.thing, refused.value, refused.bound, refused.remedy)


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
            self._wire.send(encode(_refusal(refused)))

    def _run(self, request: Start) -> None:
        if self._latched or self._page.pressed():
            raise Refused(
                "the motion process",
                "stopped",
                "reset",
                "look at the patient, reset the stop and start again",
            )
        with _undisturbed(request.plan.realtime):
            rig = self._open_rig(request.plan)
            line = RunLine(self._wire, self._page, rig.clock, queued=request.plan.realtime)
            around = Surroundings(self._page, line.sink, line, line, lambda: line.say(Started()))
            end = run(request.plan, request.certificate, rig, around)
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
