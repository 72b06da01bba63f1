"""The gateway before a real viewport server, over real sockets."""

from __future__ import annotations

import contextlib
import http.client
import socket
import threading
from pathlib import Path

import msgspec
import pytest
import viser
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect

from rehab_app.web import create_app
from rehab_app.web.server import ShellServer, listen
from rehab_app.web.viewport.private_server import LOOPBACK, PrivateServer
from rehab_app.web.visit import COOKIE

from .test_messages import CAMERA

PROTOCOL = f"viser-v{viser.__version__}"


class OnePicture:
    def __init__(self, port):
        self._port = port

    def live_port(self):
        return self._port

    def review_port(self, recording):
        return self._port

    def close(self):
        pass


@pytest.fixture(scope="module")
def picture():
    server = PrivateServer("Picture")
    yield server
    server.stop()


@pytest.fixture(scope="module")
def served(clinic, picture):
    """Host and port of the clinic with that picture, and its application."""
    app = create_app(clinic, open_viewports=lambda _: OnePicture(picture.get_port()))
    line = listen("127.0.0.1", 0)
    ready = threading.Event()
    server = ShellServer(app, ready.set)
    thread = threading.Thread(target=server.run, kwargs={"sockets": [line]})
    thread.start()
    assert ready.wait(20)
    yield f"127.0.0.1:{line.getsockname()[1]}", app
    server.should_exit = True
    thread.join()
    line.close()


@pytest.fixture
def look(served):
    """Opens the viewport's websocket as somebody."""
    host, app = served

    def opened(role="therapist", path="/live/view", origin=None, protocol=PROTOCOL):
        headers = {} if role is None else {"Cookie": f"{COOKIE}={app.state.site.begin(role)}"}
        return connect(
            f"ws://{host}{path}",
            origin=f"http://{host}" if origin is None else origin,
            subprotocols=[protocol],
            additional_headers=headers,
            compression=None,
            max_size=None,
        )

    return opened


def get(served, path, role="therapist"):
    host, app = served
    line = http.client.HTTPConnection(host, timeout=10)
    headers = {"Cookie": f"{COOKIE}={app.state.site.begin(role)}"} if role else {}
    line.request("GET", path, headers=headers)
    answer = line.getresponse()
    body = answer.read()
    line.close()
    return answer, body


def exhaust(browser):
    while True:
        browser.recv(timeout=5)


def say(browser, **message):
    browser.send(msgspec.msgpack.encode(message))


def test_the_page_runs_only_its_own_scripts(served):
    answer, body = get(served, "/live/view/")
    assert answer.status == 200
    assert b"<title>Viser</title>" in body
    policy = answer.headers["content-security-policy"]
    script = policy.split("script-src ")[1].split(";")[0]
    assert script.count("'sha256-") == 2
    assert "'unsafe-inline'" not in script
    assert "'unsafe-eval'" not in policy
    assert "connect-src 'self' data: blob:;" in policy
    assert "frame-ancestors 'self'" in policy
    assert answer.headers["x-frame-options"] == "SAMEORIGIN"


@pytest.mark.parametrize("role", [None, "patient"])
def test_the_page_needs_sign_in_and_role(served, role):
    answer, body = get(served, "/live/view/", role)
    assert answer.status == (401 if role is None else 403)
    assert b"Viser" not in body


@pytest.mark.parametrize(
    "query", ["websocket=ws://evil.example", "playbackPath=/x", "websocket=", "websocket=a&websocket=b"]
)
def test_parameters_that_lead_elsewhere_are_refused(served, query):
    assert get(served, f"/live/view/?{query}")[0].status == 400


def test_the_address_that_the_viewport_writes_itself_is_dropped(served):
    answer, _ = get(served, f"/live/view/?websocket=ws://{served[0]}/live/view")
    assert (answer.status, answer.headers["location"]) == (303, "/live/view/")


@pytest.mark.parametrize("role", ["administrator", "therapist", "assistant", "auditor"])
def test_those_who_may_look_get_the_picture_in_its_own_protocol(look, role):
    with look(role) as browser:
        assert browser.subprotocol == PROTOCOL
        assert len(browser.recv(timeout=5)) > 16


@pytest.mark.parametrize(
    "wrong",
    [
        {"role": None},
        {"role": "patient"},
        {"origin": "https://evil.example"},
        {"origin": ""},
        {"protocol": "other"},
        {"path": "/live/view?websocket=ws://evil.example"},
        {"path": "/review/..%2fsecret/view"},
    ],
)
def test_nobody_else_is_connected(look, picture, wrong):
    before = len(picture.get_clients())
    with pytest.raises(InvalidStatus):
        look(**wrong)
    assert len(picture.get_clients()) == before


def test_a_value_arrives_and_an_attack_on_the_same_control_does_not(look, picture):
    arrived = threading.Event()
    slider = picture.gui.add_slider("s", 0, 10, 1, 0)
    slider.on_update(lambda _: arrived.set())
    with look() as browser:
        say(browser, **CAMERA)
        say(browser, type="GuiUpdateMessage", uuid=slider._impl.uuid, updates={"removed": True})
        say(browser, type="GuiUpdateMessage", uuid=slider._impl.uuid, updates={"disabled": True})
        say(browser, type="ShareUrlRequest")
        browser.send("text is not spoken here")
        say(browser, type="GuiUpdateMessage", uuid=slider._impl.uuid, updates={"value": 4})
        assert arrived.wait(5)
        assert slider.value == 4
        assert slider._impl.removed is False
        assert slider.disabled is False
        assert picture._share_tunnel is None


def test_an_onlooker_moves_no_shared_control(look, picture):
    slider = picture.gui.add_slider("t", 0, 10, 1, 0)
    last = threading.Event()
    mark = picture.gui.add_slider("u", 0, 10, 1, 0)
    mark.on_update(lambda _: last.set())
    with look("auditor") as onlooker, look("therapist") as therapist:
        for browser in (onlooker, therapist):
            say(browser, **CAMERA)
        say(onlooker, type="GuiUpdateMessage", uuid=slider._impl.uuid, updates={"value": 4})
        say(onlooker, type="GuiUpdateMessage", uuid=mark._impl.uuid, updates={"value": 4})
        say(therapist, type="GuiUpdateMessage", uuid=mark._impl.uuid, updates={"value": 9})
        assert last.wait(5)
        assert mark.value == 9
        assert slider.value == 0


def test_a_picture_ends_with_the_sign_in(look, served, monkeypatch):
    monkeypatch.setattr("rehab_app.web.gateway.wire._CHECK_S", 0.02)
    seal = served[1].state.site.seal
    with look("assistant") as browser:
        monkeypatch.setattr(seal, "read", lambda _: None)
        with pytest.raises(ConnectionClosed):
            exhaust(browser)


def test_the_real_viewports_listen_on_loopback_only(clinic):
    from rehab_app.web.screens import Screens

    screens = Screens(clinic)
    with contextlib.closing(screens):
        port = screens.live_port()
        assert screens.live_port() == port
        with contextlib.closing(http.client.HTTPConnection(LOOPBACK, port, timeout=5)) as line:
            line.request("GET", "/")
            assert line.getresponse().status == 200
        addresses = {
            row.split()[1].split(":")[0]
            for row in Path("/proc/net/tcp").read_text().splitlines()
            if row.split()[3] == "0A" and int(row.split()[1].split(":")[1], 16) == port
        }
        assert addresses == {socket.inet_aton(LOOPBACK)[::-1].hex().upper()}
        assert LOOPBACK.startswith("127.")
