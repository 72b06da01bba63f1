"""The motion process: same result as in-process, stops, dies with its app, and never hangs it."""

from __future__ import annotations

import os
import select
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import pytest

from robot_iface.errors import Refused
from robot_iface.link import MotionClient
from robot_iface.types import Plan, RunEnd, SafetyEvent, SafetyState

MakePlan = Callable[..., Plan]


@pytest.fixture(scope="module")
def client() -> Iterator[MotionClient]:
    with MotionClient() as motion:
        yield motion


@pytest.fixture
def short(fist: Any) -> Any:
    return fist(1.0, 6.0, 20.0)


def end_of(client: MotionClient) -> RunEnd:
    last = [message for message in client.messages() if isinstance(message, RunEnd)]
    assert len(last) == 1
    return last[0]


def test_a_run_through_the_link_equals_one_in_process(
    client: MotionClient, make_plan: MakePlan, short: Any, course: Any
) -> None:
    plan = make_plan("tremor", path=short, seed=3)
    certificate = client.rehearse(plan)
    assert certificate.accepted
    client.start(plan, certificate)
    end = end_of(client)
    assert end == course(plan).end
    assert client.live().phase == "done"


def test_refusals_come_through_and_the_process_lives_on(
    client: MotionClient, make_plan: MakePlan, short: Any
) -> None:
    plan = make_plan(path=short)
    certificate = client.rehearse(plan)
    with pytest.raises(Refused, match="a different twin"):
        client.start(make_plan("weak", path=short), certificate)
    other = replace(plan, device="nobody")
    with pytest.raises(Refused, match="'nobody'"):
        client.start(other, client.rehearse(other))
    client.start(plan, certificate)
    assert end_of(client).completed


def test_stop_in_real_time_latches_within_ticks_and_needs_a_reset(
    client: MotionClient, make_plan: MakePlan, short: Any
) -> None:
    plan = make_plan(path=short)
    certificate = client.rehearse(plan)
    client.start(replace(plan, realtime=True), certificate)
    events, pressed_after = [], 40
    for count, message in enumerate(client.messages()):
        if count == pressed_after:
            client.press_stop()
        if isinstance(message, SafetyEvent):
            events.append(message)
        if isinstance(message, RunEnd):
            assert message.state == SafetyState.CAT1
            assert not message.completed
    assert events[0].cause == "e-stop"
    latency_ns = client.stop_latency_ns()
    assert latency_ns is not None
    assert latency_ns > 0
    assert client.live().stop_latched_t_ns > 0
    with pytest.raises(Refused, match="reset"):
        client.start(plan, certificate)
    client.reset()
    assert not client.stop_pressed
    client.start(plan, certificate)
    assert end_of(client).completed


def test_a_silent_app_is_braked_for_in_real_time(
    client: MotionClient, make_plan: MakePlan, short: Any
) -> None:
    plan = make_plan(path=short)
    client.start(replace(plan, realtime=True), client.rehearse(plan))
    select.select([], [], [], 0.6)  # the app does nothing, and so does not beat
    causes = [message.cause for message in client.messages() if isinstance(message, SafetyEvent)]
    assert "heartbeat-lost" in causes
    assert not client.stop_pressed
    with pytest.raises(Refused, match="reset"):
        client.start(plan, client.rehearse(plan))
    client.reset()


def test_orders_reach_the_run(client: MotionClient, make_plan: MakePlan, short: Any) -> None:
    plan = make_plan(path=short)
    client.start(replace(plan, realtime=True), client.rehearse(plan))
    seen: list[str] = []
    for count, message in enumerate(client.messages()):
        if count == 40:
            client.pain()
        if isinstance(message, SafetyEvent):
            seen.append(message.cause)
            client.press_stop()
    assert seen[0] == "pain"
    client.reset()


def test_a_motion_process_that_dies_is_a_refusal_and_no_hang(make_plan: MakePlan, short: Any) -> None:
    with MotionClient() as motion:
        plan = make_plan(path=short, realtime=True)
        motion.start(plan, motion.rehearse(plan))
        os.kill(motion.pid, signal.SIGKILL)
        with pytest.raises(Refused, match="motion process is gone"):
            list(motion.messages())
        assert motion.live() is not None
        motion.press_stop()
        with pytest.raises(Refused, match="motion process is gone"):
            motion.rehearse(plan)


_APP = """
import sys
sys.path.insert(0, {folder!r})
from conftest import fist, make_plan
from robot_iface.link import MotionClient
plan = make_plan(path=fist(1.0, 6.0, 20.0), realtime=True, repetitions=50)
motion = MotionClient()
motion.start(plan, motion.rehearse(plan))
for count, message in enumerate(motion.messages()):
    if count == 20:
        sys.stdout.write(str(motion.pid) + "\\n")
        sys.stdout.flush()
"""


def test_killing_the_app_ends_the_motion_process() -> None:
    folder = os.path.dirname(os.path.dirname(__file__))
    app = subprocess.Popen([sys.executable, "-c", _APP.format(folder=folder)], stdout=subprocess.PIPE)
    assert app.stdout is not None
    pid = int(app.stdout.readline())
    motion = os.pidfd_open(pid)
    app.kill()
    app.wait()
    app.stdout.close()
    ended, _, _ = select.select([motion], [], [], 10.0)
    os.close(motion)
    assert ended, "the motion process outlived its app"
    assert time.monotonic() > 0
