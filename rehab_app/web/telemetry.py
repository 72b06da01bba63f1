"""Around every request: its id, time, line in the log and count; of a path only the route is told."""

from __future__ import annotations

import logging
import time
from typing import Any

from starlette.datastructures import MutableHeaders
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from rehab_app.web.guard import STOP_PATH
from rehab_app.web.meters import Meters
from rehab_app.web.server_log import new_request_id, request_id, tell

NO_ROUTE = "none"
# Asked for once a second by every page: at the usual level they would drown everything else.
_POLLED = frozenset(("/stop/state", "/live/beat", "/here", "/static", "/mine/state", "/healthz", "/metrics"))
_FAILED = 500
_METHODS = frozenset(("GET", "HEAD", "POST"))


class Telemetry:
    """ASGI middleware around the guard.

    Args:
        app: The application.
        meters: Where it is counted.
    """

    def __init__(self, app: ASGIApp, meters: Meters) -> None:
        self._app = app
        self._meters = meters

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer, then tell."""
        if scope["type"] == "http":
            await self._answer(scope, receive, send)
        elif scope["type"] == "websocket":
            with self._meters.websockets.track_inprogress():
                await self._app(scope, receive, send)
        else:
            await self._app(scope, receive, send)

    async def _answer(self, scope: Scope, receive: Receive, send: Send) -> None:
        began_s, name, status = time.perf_counter(), new_request_id(), _FAILED
        token = request_id.set(name)

        async def heard(message: Message) -> None:
            nonlocal status
            if message["type"] == "http.response.start":
                status = message["status"]
                MutableHeaders(scope=message)["x-request-id"] = name
            await send(message)

        try:
            await self._app(scope, receive, heard)
        finally:
            self._told(scope, status, time.perf_counter() - began_s)
            request_id.reset(token)

    def _told(self, scope: Scope, status: int, seconds: float) -> None:
        route = route_of(scope)
        method = scope["method"] if scope["method"] in _METHODS else "other"
        self._meters.answered(method, route, status, seconds)
        if route == STOP_PATH:
            self._meters.stopped(seconds)
        tell(
            "request",
            _level(route, status),
            method=method,
            route=route,
            status=status,
            duration_s=round(seconds, 6),
            client=_address(scope),
        )


def route_of(scope: Scope) -> str:
    """Template of the path, such as ``/patients/{patient}``: neither pseudonyms nor what somebody typed."""
    route: Any = scope.get("route")
    return str(getattr(route, "path", "") or NO_ROUTE)


def _level(route: str, status: int) -> int:
    if status >= _FAILED:
        return logging.WARNING if route in _POLLED else logging.ERROR
    return logging.DEBUG if route in _POLLED else logging.INFO


def _address(scope: Scope) -> str:
    client = scope.get("client")
    return str(client[0]) if client else ""
