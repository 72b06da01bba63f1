"""What passes the link comes out as it went in; what does not belong there is refused."""

from __future__ import annotations

import math
import socket
import struct
from collections.abc import Callable
from dataclasses import fields, is_dataclass
from typing import Any

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robot_iface.errors import Refused
from robot_iface.link.codec import decode, encode
from robot_iface.link.messages import MESSAGES, Refusal, Start
from robot_iface.link.page import SharedPage
from robot_iface.link.wire import Wire, WireClosed
from robot_iface.runtime import LiveSample, Pause, SetSpeed
from robot_iface.types import Certificate, Plan, SafetyEvent, SafetyState

MakePlan = Callable[..., Plan]


def same(one: Any, other: Any) -> bool:
    if is_dataclass(one):
        pairs = [(getattr(one, entry.name), getattr(other, entry.name)) for entry in fields(one)]
        return type(one) is type(other) and all(same(*pair) for pair in pairs)
    if isinstance(one, np.ndarray):
        return one.dtype == other.dtype and np.array_equal(one, other)
    return bool(one == other) or (isinstance(one, float) and math.isnan(one) and math.isnan(other))


def test_every_message_of_a_run_survives_the_link(make_plan: MakePlan, fist: Any, course: Any) -> None:
    run = course(make_plan(path=fist(1.0, 6.0, 20.0), stop_at_s=(2.0,)))
    for message in run.messages:
        assert same(decode(encode(message)), message)


def test_a_plan_with_its_certificate_survives_the_link(make_plan: MakePlan) -> None:
    certificate = Certificate("a" * 64, True, "within every bound", (0.1,) * 12, 3.0, ("path:1",))
    request = Start(make_plan(), certificate)
    assert same(decode(encode(request)), request)


def test_what_is_no_message_is_not_sent() -> None:
    with pytest.raises(TypeError):
        encode({"stop": True})


@settings(max_examples=200, deadline=None)
@given(st.binary(max_size=200))
def test_random_bytes_are_refused(content: bytes) -> None:
    with pytest.raises(Refused, match="link message"):
        decode(content)


@pytest.mark.parametrize(
    "body",
    [
        {"t_ns": ["f8", [1000000000], b""]},
        {"t_ns": ["f8", [-1], b""]},
        {"t_ns": ["O8", [1], b"12345678"]},
        {"t_ns": ["f8", [1, 1, 1], b"12345678"]},
    ],
)
def test_an_array_that_does_not_fit_its_bytes_is_refused(body: Any) -> None:
    content = msgspec.msgpack.encode(["TickBlock", body])
    with pytest.raises(Refused):
        decode(content)


def test_a_speed_out_of_bounds_is_refused_on_arrival() -> None:
    content = encode(SetSpeed(0.5)).replace(struct.pack(">d", 0.5), struct.pack(">d", 5.0))
    with pytest.raises(Refused, match="speed"):
        decode(content)


def test_names_on_the_wire_are_the_names_of_the_types() -> None:
    assert all(name == kind.__name__ for name, kind in MESSAGES.items())


def test_messages_arrive_whole_and_in_order_whatever_the_pieces() -> None:
    ours, theirs = socket.socketpair()
    reader = Wire(ours)
    contents = [encode(Refusal("a" * size, "", "", "")) for size in (0, 5, 300)]
    stream = b"".join(struct.pack("<I", len(content)) + content for content in contents)
    received = []
    with theirs:
        for byte in stream:
            theirs.send(bytes([byte]))
            content = reader.receive(0.0)
            if content is not None:
                received.append(content)
    assert received == contents
    with pytest.raises(WireClosed):
        reader.receive(0.1)
    reader.close()


def test_queueing_never_waits_and_the_rest_follows() -> None:
    ours, theirs = socket.socketpair()
    writer, reader = Wire(ours), Wire(theirs)
    content = bytes(3_000_000)
    writer.queue(content)
    assert writer.unsent_bytes > 0
    received = None
    while received is None:
        received = reader.receive(0.0)
        writer.push()
    assert received == content
    assert writer.unsent_bytes == 0
    reader.close()
    with pytest.raises(WireClosed):
        writer.send(content)
    writer.close()


def test_an_announced_giant_is_refused() -> None:
    ours, theirs = socket.socketpair()
    reader = Wire(ours)
    with theirs:
        theirs.send(struct.pack("<I", 2**31))
        with pytest.raises(Refused, match="at most"):
            reader.receive(0.1)
    reader.close()


def test_a_reader_may_ask_for_short_messages_only() -> None:
    ours, theirs = socket.socketpair()
    writer, reader = Wire(ours), Wire(theirs)
    writer.send(bytes(100))
    assert reader.receive(0.1, 100) == bytes(100)
    writer.send(bytes(101))
    with pytest.raises(Refused, match="at most 100 bytes"):
        reader.receive(0.1, 100)
    writer.close()
    reader.close()


def test_the_page_shows_what_was_written() -> None:
    page = SharedPage()
    assert page.read_live().t_ns == 0
    rows = np.arange(12.0)
    sample = LiveSample(
        7,
        rows,
        rows + 1,
        rows + 2,
        1.5,
        0.5,
        3,
        "move",
        "patient",
        SafetyState.ACTIVE,
        rows + 3,
        0,
        84_000,
        2,
    )
    page.write_live(sample)
    assert same(page.read_live(), sample)
    page.close()


def test_a_writer_that_died_while_writing_does_not_hang_the_reader() -> None:
    page = SharedPage()
    rows = np.zeros(12)
    page.write_live(LiveSample(9, rows, rows, rows, 0.0, 0.0, 0, "rest", "", SafetyState.HOLD, rows))
    assert page.read_live().t_ns == 9
    page._words[5] += 1
    assert page.read_live().t_ns == 9
    page.close()


def test_the_stop_word_keeps_its_first_time_until_it_is_cleared() -> None:
    page = SharedPage()
    assert not page.pressed()
    page.press_stop()
    first = page.pressed_t_ns
    page.press_stop()
    assert page.pressed()
    assert page.pressed_t_ns == first > 0
    page.latch()
    assert page.latched_t_ns >= first
    page.clear_stop()
    assert not page.pressed()
    assert page.latched_t_ns == 0
    page.close()


def test_events_without_numbers_survive() -> None:
    event = SafetyEvent(5, "e-stop", SafetyState.CAT1, "", math.nan, math.nan)
    assert same(decode(encode(event)), event)
    assert same(decode(encode(Pause())), Pause())


def test_a_press_after_the_end_does_no_harm() -> None:
    page = SharedPage()
    page.close()
    page.press_stop()
    page.beat()
    assert page.read_live().t_ns == 0
