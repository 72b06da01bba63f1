"""The port: refused in one sentence where it is taken; small send buffers."""

from __future__ import annotations

import contextlib
import socket

import pytest

from rehab_app.errors import Refused
from rehab_app.web import serve
from rehab_app.web.gateway.client_page import unpack_88
from rehab_app.web.server import listen


def test_a_port_in_use_is_refused_before_anything_starts(clinic):
    with contextlib.closing(listen("127.0.0.1", 0)) as line:
        port = line.getsockname()[1]
        with pytest.raises(Refused, match=rf"port {port} on 127.0.0.1 is in use"):
            serve(clinic, port=port)


def test_an_address_of_another_machine_is_refused():
    with pytest.raises(Refused, match="not usable"):
        listen("192.0.2.1", 0)


def test_send_buffers_are_small():
    with contextlib.closing(listen("127.0.0.1", 0)) as line:
        assert line.getsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF) <= 2 * 64 * 1024


@pytest.mark.parametrize("length", range(12))
def test_base_88_is_unpacked(length):
    alphabet = [chr(code) for code in range(0x21, 0x7F) if chr(code) not in "\"&<>'`"]
    content = bytes((37 * number + 200) % 256 for number in range(length))
    text = ""
    for start in range(0, length, 4):
        part = content[start : start + 4]
        number, digits = int.from_bytes(part, "big"), ""
        for _ in range(len(part) + 1):
            number, digit = divmod(number, 88)
            digits = alphabet[digit] + digits
        text += digits
    assert unpack_88(text) == content
