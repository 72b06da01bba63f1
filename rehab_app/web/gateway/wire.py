"""The websocket between a browser and a viewport, filtered in one direction and bounded in the other."""

from __future__ import annotations

import asyncio
import socket
from collections.abc import Awaitable, Callable

from starlette.concurrency import run_in_threadpool
from starlette.websockets import WebSocket, WebSocketDisconnect
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed, InvalidHandshake
from websockets.typing import Subprotocol

from rehab_app.access import Account, Verb
from rehab_app.errors import Refused
from rehab_app.web.gateway.messages import let_through
from rehab_app.web.gateway.picture import REFUSED_PARAMETERS
from rehab_app.web.presence import present
from rehab_app.web.site import Site
from rehab_app.web.viewport import LOOPBACK

# Small buffers: a slow browser's picture is then old by fractions of a second, and the viewport, which keeps
# only the newest value of each property, skips what would be late anyway.
BUFFER_BYTES = 64 * 1024
_CHECK_S = 5.0
_POLICY_VIOLATION = 1008
_LARGEST_FRAME = 64 * 1024 * 1024
_PROTOCOL = "viser-v"


def endpoint(port_of: Callable[[Site, str], int], control: Verb) -> Callable[[WebSocket], Awaitable[None]]:
    """A websocket route's endpoint.

    Args:
        port_of: The loopback port for the site and the recording in the path.
        control: Verb of those who may move the viewport's controls.
    """

    async def answer(browser: WebSocket) -> None:
        site: Site = browser.app.state.site
        account = await run_in_threadpool(_may_look, site, browser)
        protocol = next((name for name in browser.scope["subprotocols"] if name.startswith(_PROTOCOL)), None)
        if account is None or protocol is None:
            await browser.close(_POLICY_VIOLATION)
            return
        try:
            port = await run_in_threadpool(port_of, site, str(browser.path_params.get("recording", "")))
            viewport = await _reach(port, protocol)
        except (Refused, OSError, InvalidHandshake):
            await browser.close(_POLICY_VIOLATION)
            return
        async with viewport:
            await browser.accept(viewport.subprotocol)
            await _join(site, browser, viewport, account.may(control))

    return answer


def _may_look(site: Site, browser: WebSocket) -> Account | None:
    """The account behind a websocket, None where it may not look or asks with a refused parameter."""
    if any(name in REFUSED_PARAMETERS for name in browser.query_params):
        return None
    there = present(site, browser)
    # A page that is covered because nobody used it keeps its picture: it must not hold the movement under it.
    return there.account if there is not None and there.account.may("view") else None


async def _reach(port: int, protocol: str) -> ClientConnection:
    """Connect to a viewport on loopback, with a small receive buffer."""
    line = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    line.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, BUFFER_BYTES)
    line.setblocking(False)
    await asyncio.get_running_loop().sock_connect(line, (LOOPBACK, port))
    return await connect(
        f"ws://{LOOPBACK}:{port}/",
        sock=line,
        subprotocols=[Subprotocol(protocol)],
        compression=None,
        max_size=_LARGEST_FRAME,
        max_queue=1,
        ping_interval=None,
        proxy=None,
    )


async def _join(site: Site, browser: WebSocket, viewport: ClientConnection, controls: bool) -> None:
    """Carry messages both ways until either side leaves or the sign-in ends."""
    tasks = [
        asyncio.ensure_future(_to_viewport(browser, viewport, controls)),
        asyncio.ensure_future(_to_browser(browser, viewport)),
        asyncio.ensure_future(_until_signed_out(site, browser)),
    ]
    try:
        await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
    finally:
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)


async def _to_viewport(browser: WebSocket, viewport: ClientConnection, controls: bool) -> None:
    while True:
        message = await browser.receive()
        if message["type"] == "websocket.disconnect":
            return
        raw: bytes | None = message.get("bytes")
        kept = None if raw is None else let_through(raw, controls)
        if kept is not None:
            try:
                await viewport.send(kept)
            except ConnectionClosed:
                return


async def _to_browser(browser: WebSocket, viewport: ClientConnection) -> None:
    try:
        async for message in viewport:
            if isinstance(message, bytes):
                await browser.send_bytes(message)
    except (ConnectionClosed, WebSocketDisconnect):
        return
    await browser.close(viewport.close_code or 1000)


async def _until_signed_out(site: Site, browser: WebSocket) -> None:
    """Close the picture of somebody who signed out, or whose account was closed."""
    while await run_in_threadpool(_may_look, site, browser) is not None:
        await asyncio.sleep(_CHECK_S)
    await browser.close(_POLICY_VIOLATION)
