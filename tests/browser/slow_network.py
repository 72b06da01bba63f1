"""A network that becomes slow: a relay before the server whose rate towards the browser a test sets.

The developer tools' own emulation does not reach the websocket of the picture, which a worker holds.
"""

from __future__ import annotations

import contextlib
import socket
import threading
import time
from collections.abc import Generator
from contextlib import contextmanager

_PIECE = 1024
_BUFFER = 8 * 1024


class SlowNetwork:
    """Carries every connection to a server; bytes towards the browser share one rate.

    Args:
        port: Port of the server on loopback.

    Attributes:
        port: Port of the relay.
        rate: Bytes per second towards the browser, None for as fast as it goes.
    """

    def __init__(self, port: int) -> None:
        self.rate: float | None = None
        self._server = port
        self._door = socket.create_server(("127.0.0.1", 0))
        self.port: int = self._door.getsockname()[1]
        self._turn = threading.Lock()
        self._lines: list[socket.socket] = []
        self._accepting = threading.Thread(target=self._accept, daemon=True)
        self._accepting.start()

    def close(self) -> None:
        """Cut every line."""
        self._door.shutdown(socket.SHUT_RDWR)
        self._accepting.join()
        self._door.close()
        for line in self._lines:
            with contextlib.suppress(OSError):
                line.shutdown(socket.SHUT_RDWR)
            line.close()

    def _accept(self) -> None:
        with contextlib.suppress(OSError):
            while True:
                browser = self._door.accept()[0]
                server = socket.socket()
                server.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _BUFFER)
                server.connect(("127.0.0.1", self._server))
                self._lines += [browser, server]
                for source, sink, slow in ((browser, server, False), (server, browser, True)):
                    threading.Thread(target=self._carry, args=(source, sink, slow), daemon=True).start()

    def _carry(self, source: socket.socket, sink: socket.socket, slow: bool) -> None:
        with contextlib.suppress(OSError):
            while piece := source.recv(_PIECE if slow and self.rate else 64 * _PIECE):
                rate = self.rate
                if slow and rate is not None:
                    with self._turn:
                        time.sleep(len(piece) / rate)
                sink.sendall(piece)
        with contextlib.suppress(OSError):
            sink.shutdown(socket.SHUT_WR)


@contextmanager
def slow_network(port: int) -> Generator[SlowNetwork]:
    """A relay until the end of the block."""
    network = SlowNetwork(port)
    try:
        yield network
    finally:
        network.close()
