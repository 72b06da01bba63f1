"""The door: refuses foreign hosts, foreign origins and oversized bodies, and adds the security headers."""

from __future__ import annotations

import ipaddress
import socket
from collections.abc import Callable
from urllib.parse import urlsplit

from starlette.datastructures import Headers, MutableHeaders
from starlette.requests import HTTPConnection
from starlette.responses import PlainTextResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from rehab_app.web.language import asked_for, speak
from rehab_app.web.policy import ALWAYS, DEFAULTS, TRANSPORT

LARGEST_BODY = 64 * 1024
STOP_PATH = "/stop"


class Guard:
    """ASGI middleware around the whole application.

    Args:
        app: The application.
        hosts: Names that this server answers to, besides IP addresses.
        usual_language: Gives the clinic's language without waiting for anything.
    """

    def __init__(
        self, app: ASGIApp, hosts: frozenset[str], usual_language: Callable[[], str] = lambda: ""
    ) -> None:
        self._app = app
        self._hosts = hosts
        self._usual_language = usual_language

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Let a connection pass or refuse it."""
        if scope["type"] == "lifespan":
            await self._app(scope, receive, send)
            return
        asked = HTTPConnection(scope)
        speak(asked_for(asked.headers, asked.cookies, self._usual_language()))
        status, why = self._refusal(scope)
        if scope["type"] == "websocket":
            await self._socket(scope, receive, send, why)
            return

        async def with_headers(message: Message) -> None:
            if message["type"] == "http.response.start":
                _add_headers(MutableHeaders(scope=message), encrypted=scope["scheme"] == "https")
            await send(message)

        answer: ASGIApp = PlainTextResponse(why, status) if why else self._app
        await answer(scope, receive, with_headers)

    async def _socket(self, scope: Scope, receive: Receive, send: Send, why: str) -> None:
        if why:
            await receive()
            await send({"type": "websocket.close", "code": 1008, "reason": why})
        else:
            await self._app(scope, receive, send)

    def _refusal(self, scope: Scope) -> tuple[int, str]:
        """Status and sentence; an empty sentence lets the connection pass."""
        headers = Headers(scope=scope)
        host = headers.get("host", "")
        if not known_host(host, self._hosts):
            return 421, f"This server does not answer to the name {host!r}."
        reads = scope["type"] == "http" and scope["method"] in ("GET", "HEAD")
        if reads:
            return 200, ""
        origin = headers.get("origin")
        # A stop without an Origin (a foot switch, a script) is let through: it can only make things safer.
        absent_is_fine = scope["type"] == "http" and scope["path"] == STOP_PATH
        same = _same_site(origin, host, scope["scheme"]) if origin else absent_is_fine
        if not same:
            return 403, "This request came from another site and was refused."
        if scope["type"] == "http" and _too_large(headers):
            return 413, f"The request is larger than {LARGEST_BODY} bytes."
        return 200, ""


def own_names(host: str) -> frozenset[str]:
    """Names by which people may reach a server that listens on ``host``."""
    machine = socket.gethostname().casefold()
    return frozenset(("localhost", host.casefold(), machine, f"{machine}.local", socket.getfqdn().casefold()))


def known_host(header: str, names: frozenset[str]) -> bool:
    """Whether a Host header names this server; a page of a stranger that re-binds its name here does not."""
    try:
        name = urlsplit(f"//{header}").hostname or ""
    except ValueError:
        return False
    if name in names:
        return True
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True


def _same_site(origin: str, host: str, scheme: str) -> bool:
    """Whether an Origin is this server, by the same name, port and scheme (a websocket's page is of HTTP)."""
    sent = urlsplit(origin)
    return (sent.scheme, sent.netloc.casefold()) == (scheme.replace("ws", "http", 1), host.casefold())


def _too_large(headers: Headers) -> bool:
    length = headers.get("content-length", "")
    if "transfer-encoding" in headers:
        return True
    return bool(length) and (not length.isdecimal() or int(length) > LARGEST_BODY)


def _add_headers(headers: MutableHeaders, *, encrypted: bool) -> None:
    for name, value in DEFAULTS.items():
        headers.setdefault(name, value)
    for name, value in ALWAYS.items():
        headers[name] = value
    if encrypted:
        headers.setdefault(*TRANSPORT)
