"""Framed messages over a socket pair: four bytes of length, then the message."""

from __future__ import annotations

import select
import socket
import struct
import time
from collections import deque

from robot_iface.errors import Refused
from robot_iface.link.codec import MAX_MESSAGE_BYTES

_LENGTH = struct.Struct("<I")
_CHUNK_BYTES = 64 * 1024


class WireClosed(Exception):
    """The other process is gone."""


class Wire:
    """One end of the link. Not shared between threads without a lock.

    Args:
        end: A connected stream socket, owned by the wire from now on.
    """

    def __init__(self, end: socket.socket) -> None:
        end.setblocking(False)
        self._end = end
        self._received = bytearray()
        self._unsent: deque[memoryview] = deque()
        self.unsent_bytes = 0
        self._readable = select.poll()
        self._readable.register(end, select.POLLIN)
        self._writable = select.poll()
        self._writable.register(end, select.POLLOUT)

    def queue(self, content: bytes) -> None:
        """Send what the other side takes now and keep the rest for later; never waits.

        Raises:
            WireClosed: The other process is gone.
        """
        framed = memoryview(_LENGTH.pack(len(content)) + content)
        self._unsent.append(framed)
        self.unsent_bytes += len(framed)
        self.push()

    def send(self, content: bytes, timeout_s: float | None = None) -> None:
        """Send a message, waiting until the other side has taken it.

        Raises:
            WireClosed: The other process is gone, or took nothing for ``timeout_s``.
        """
        self.queue(content)
        self.drain(timeout_s)

    def drain(self, timeout_s: float | None = None) -> None:
        """Wait until everything queued is sent.

        Raises:
            WireClosed: The other process is gone, or took nothing for ``timeout_s``.
        """
        while self._unsent:
            if not self._writable.poll(None if timeout_s is None else 1000.0 * timeout_s):
                raise WireClosed
            self.push()

    def push(self) -> None:
        """Send what can be sent without waiting.

        Raises:
            WireClosed: The other process is gone.
        """
        while self._unsent:
            try:
                sent = self._end.send(self._unsent[0])
            except BlockingIOError:
                return
            except OSError as error:
                raise WireClosed from error
            self.unsent_bytes -= sent
            rest = self._unsent.popleft()[sent:]
            if rest:
                self._unsent.appendleft(rest)

    def receive(self, timeout_s: float | None = 0.0, at_most_bytes: int = MAX_MESSAGE_BYTES) -> bytes | None:
        """The next message, or None if none came within ``timeout_s`` (None waits for ever).

        No more than ``at_most_bytes`` and one chunk are ever kept, whatever the other side sends.

        Raises:
            WireClosed: The other process is gone.
            Refused: A message announces more than ``at_most_bytes``; nothing after it can be read any more.
        """
        deadline = None if timeout_s is None else time.monotonic() + timeout_s
        while True:
            content = self._next(at_most_bytes)
            if content is not None:
                return content
            left_ms = None if deadline is None else max(0.0, 1000.0 * (deadline - time.monotonic()))
            if not self._readable.poll(left_ms):
                return None
            self._fill()

    def close(self) -> None:
        """Close this end."""
        self._end.close()

    def _next(self, at_most_bytes: int) -> bytes | None:
        if len(self._received) < _LENGTH.size:
            return None
        (length,) = _LENGTH.unpack_from(self._received)
        if length > at_most_bytes:
            raise Refused(
                "link message",
                f"{length} bytes",
                f"at most {at_most_bytes} bytes",
                "restart the app so that both processes run the same version",
            )
        end = _LENGTH.size + length
        if len(self._received) < end:
            return None
        content = bytes(self._received[_LENGTH.size : end])
        del self._received[:end]
        return content

    def _fill(self) -> None:
        try:
            chunk = self._end.recv(_CHUNK_BYTES)
        except BlockingIOError:
            return
        except OSError as error:
            raise WireClosed from error
        if not chunk:
            raise WireClosed
        self._received += chunk
