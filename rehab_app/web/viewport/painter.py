"""A thread that draws a room until it is closed; a slow frame is skipped and not caught up."""

from __future__ import annotations

import contextlib
import contextvars
import threading
import time
from collections.abc import Callable

from rehab_app.web.viewport.scene import Room

_AGAIN_S = 0.03


class Painter:
    """Owns a room's server and the thread that draws in it.

    Args:
        room: What is drawn.
        name: Name of the thread.
        paint: Draws once and returns the period until the next time, s.
    """

    def __init__(self, room: Room, name: str, paint: Callable[[], float]) -> None:
        self._room, self._paint = room, paint
        self._ending = threading.Event()
        spoken = contextvars.copy_context()  # it draws in the language of whoever opened it
        self._thread = threading.Thread(target=spoken.run, args=(self._work,), name=name, daemon=True)
        self._thread.start()

    @property
    def port(self) -> int:
        """Port of the viser server on the private loopback address."""
        return self._room.server.get_port()

    def close(self) -> None:
        """Stop drawing and close the server."""
        self._ending.set()
        self._thread.join()
        self._room.server.stop()

    def _work(self) -> None:
        due = time.monotonic()
        while not self._ending.is_set():
            # viser wakes its clients from this thread too; where one of them comes or leaves at that instant
            # it raises. What was assigned is sent all the same, and the next turn draws the rest.
            period_s = _AGAIN_S
            with contextlib.suppress(RuntimeError):
                period_s = self._paint()
            due = max(due + period_s, time.monotonic())
            self._ending.wait(due - time.monotonic())
