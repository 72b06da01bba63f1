"""Runs the application on one port."""

from __future__ import annotations

import asyncio
import contextlib
import errno
import os
import signal
import socket
import sys
import threading
from collections.abc import Callable, Generator

import uvicorn
from starlette.applications import Starlette

from rehab_app.errors import Refused
from rehab_app.services.clinic import Clinic
from rehab_app.services.snapshot import BUSY
from rehab_app.services.tally import ENDING
from rehab_app.web.app import create_app
from rehab_app.web.gateway.wire import BUFFER_BYTES
from rehab_app.web.heap import keep_heap_small
from rehab_app.web.notify import ALIVE, READY, STOPPING, notify, watchdog_s
from rehab_app.web.server_log import tell
from rehab_app.web.tls import TlsFiles
from rehab_app.web.uploading import keep_up

_BACKLOG = 128
_SWITCH_S = 0.0005
_NICE = -5


def serve(
    clinic: Clinic,
    host: str = "127.0.0.1",
    port: int = 8080,
    ready: Callable[[], None] | None = None,
    tls: TlsFiles | None = None,
) -> None:
    """Open the clinic to browsers until the process is interrupted.

    Args:
        clinic: The clinic, opened with ``serving=True``.
        host: Address to listen on.
        port: Port to listen on.
        ready: Called once pages are served.
        tls: Certificate and key, None for plain HTTP.

    Raises:
        Refused: The port is in use or the address is not of this machine.
    """
    line = listen(host, port)
    keep_heap_small()
    with _no_second_end(), ahead_of_others(), contextlib.suppress(KeyboardInterrupt):
        threading.Thread(target=clinic.interrupted.restore, name="restore", daemon=True).start()
        keep_up(clinic)
        server = ShellServer(create_app(clinic, host), ready, tls, lambda: stop_movement(clinic))
        server.run(sockets=[line])


def stop_movement(clinic: Clinic) -> None:
    """Stop whatever moves or records, because the server is ending; the clinic seals it as it closes."""
    state = clinic.live.snapshot().state
    tell("ending", state=state)
    if state in BUSY:
        clinic.live.press_stop(ENDING)


@contextlib.contextmanager
def ends_on_terminate() -> Generator[None]:
    """A SIGTERM within the block ends the server as Ctrl-C does: what moves is stopped and sealed.

    Once the server has ended, a second one is ignored: it would break the sealing off.
    """
    before = signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


@contextlib.contextmanager
def ahead_of_others() -> Generator[None]:
    """Threads begun in here hand the interpreter over sooner and, where permitted, run before other programs.

    The stop and the heartbeat wait for whichever thread holds the interpreter: were only their own threads
    raised, any program on the machine could still keep the holder, and with it them, from the processor.
    """
    before_s, before = sys.getswitchinterval(), os.getpriority(os.PRIO_PROCESS, 0)
    sys.setswitchinterval(_SWITCH_S)
    with contextlib.suppress(OSError):  # without the permission it stays as it is
        os.setpriority(os.PRIO_PROCESS, 0, min(before, _NICE))
    try:
        yield
    finally:
        sys.setswitchinterval(before_s)
        with contextlib.suppress(OSError):
            os.setpriority(os.PRIO_PROCESS, 0, before)


@contextlib.contextmanager
def _no_second_end() -> Generator[None]:
    """Behind the block a SIGTERM is ignored, where it ended the server within."""
    try:
        yield
    finally:
        if signal.getsignal(signal.SIGTERM) is signal.default_int_handler:
            signal.signal(signal.SIGTERM, signal.SIG_IGN)


class ShellServer(uvicorn.Server):
    """The web server: says when it is ready, gives signs of life, and stops a movement before it ends.

    Args:
        app: The application.
        ready: Called once pages are served.
        tls: Certificate and key, None for plain HTTP.
        ending: Called once it has been told to end, before anything is closed.
    """

    def __init__(
        self,
        app: Starlette,
        ready: Callable[[], None] | None = None,
        tls: TlsFiles | None = None,
        ending: Callable[[], None] | None = None,
    ) -> None:
        super().__init__(
            uvicorn.Config(
                app,
                log_config=None,  # the process decides where its log goes, see server_log
                access_log=False,
                server_header=False,
                ws="websockets-sansio",
                ws_max_size=BUFFER_BYTES,
                timeout_graceful_shutdown=2,
                ssl_certfile=None if tls is None else tls.certificate,
                ssl_keyfile=None if tls is None else tls.key,
            )
        )
        self._ready = ready
        self._ending = ending
        self._alive: asyncio.Task[None] | None = None

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        """Begin to serve."""
        await super().startup(sockets)
        if self.started:
            notify(READY)
            self._alive = asyncio.create_task(_stay_alive(watchdog_s()))
            if self._ready is not None:
                self._ready()

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        """End: first whatever moves, then the connections."""
        notify(STOPPING)
        if self._ending is not None:
            self._ending()
        if self._alive is not None:
            self._alive.cancel()
        await super().shutdown(sockets)


async def _stay_alive(period_s: float) -> None:
    """Give the sign of life from the loop that answers the stop: if that hangs, so does this."""
    while period_s > 0.0:
        notify(ALIVE)
        await asyncio.sleep(period_s)


def listen(host: str, port: int) -> socket.socket:
    """A listening socket whose connections have small send buffers (a slow browser must not lag by seconds).

    Args:
        host: Address to listen on.
        port: Port, 0 for any that is free.

    Raises:
        Refused: The port is in use or the address is not of this machine.
    """
    try:
        family, kind, protocol, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0]
        line = socket.socket(family, kind, protocol)
        try:
            line.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            line.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, BUFFER_BYTES)
            line.bind(address)
            line.listen(_BACKLOG)
        except OSError:
            line.close()
            raise
    except OSError as error:
        value = "in use" if error.errno == errno.EADDRINUSE else f"not usable ({error.strerror or error})"
        raise Refused(
            f"port {port} on {host}", value, "free", "end what uses it, or choose another with --port"
        ) from error
    line.setblocking(False)
    return line
