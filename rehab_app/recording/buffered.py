"""A live camera that is read on a thread of its own, so that a slow moment of perception loses no capture."""

from __future__ import annotations

import queue
import threading
from collections.abc import Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import replace
from types import TracebackType

from rehab_app.cameras import Camera, Capture, Frame
from rehab_app.geometry.pinhole import Intrinsics
from sessions.errors import Refused

MOST_WAITING = 60
"""Captures that wait at most: two seconds at 30 Hz, some 110 MB; of more, the newest are dropped, counted."""
_LONGEST_READ_S = 5.0


class Buffered:
    """The camera itself, read ahead.

    Args:
        camera: A live camera; entering and leaving this one enters and leaves it.
        most: Captures that wait at most.
    """

    def __init__(self, camera: Camera, most: int = MOST_WAITING) -> None:
        self._camera = camera
        self._waiting: queue.Queue[Capture | None] = queue.Queue(most)
        self._ended = threading.Event()
        self._pool: ThreadPoolExecutor | None = None
        self._reading: Future[None] | None = None

    @property
    def name(self) -> str:
        """What a session file calls this source: the camera's own name."""
        return self._camera.name

    @property
    def intrinsics(self) -> Intrinsics:
        """Camera of the colour image."""
        return self._camera.intrinsics

    @property
    def rate_hz(self) -> float:
        """Nominal frames per second."""
        return self._camera.rate_hz

    @property
    def has_depth(self) -> bool:
        """Whether frames carry depth."""
        return self._camera.has_depth

    def __enter__(self) -> Buffered:
        """Open the camera and begin to read."""
        self._camera.__enter__()
        self._ended.clear()
        self._pool = ThreadPoolExecutor(1, thread_name_prefix="camera")
        self._reading = self._pool.submit(self._read)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Stop reading, then close the camera: a device is never closed under a read, unless that hangs."""
        self._ended.set()
        if self._reading is not None:
            threading.Thread(target=self._drain, daemon=True).start()
            try:
                self._reading.exception(_LONGEST_READ_S)
            except TimeoutError:
                pass
        self._camera.__exit__(kind, error, trace)
        if self._pool is not None:
            self._pool.shutdown(wait=False)

    def frames(self) -> Iterator[Capture]:
        """The camera's captures, in order.

        Raises:
            Refused: The camera is not open, or as its own.
        """
        if self._reading is None or self._ended.is_set():
            raise Refused("camera", "closed", "open", "open it before asking for frames")
        while (capture := self._waiting.get()) is not None:
            yield capture
        self._reading.result()

    def _read(self) -> None:
        lost = 0
        try:
            for capture in self._camera.frames():
                if self._ended.is_set():
                    return
                if isinstance(capture, Frame):
                    capture = replace(capture, dropped=capture.dropped + lost)
                lost = self._hand_over(capture, lost)
        finally:
            self._waiting.put(None)

    def _hand_over(self, capture: Capture, lost: int) -> int:
        """Queue a capture; how many are lost since the last one that was queued."""
        try:
            self._waiting.put_nowait(capture)
        except queue.Full:
            return capture.dropped + 1 if isinstance(capture, Frame) else lost
        return 0 if isinstance(capture, Frame) else lost

    def _drain(self) -> None:
        """Make room for the end mark of a reader whose captures nobody takes any more."""
        while self._reading is not None and not self._reading.done():
            try:
                self._waiting.get(timeout=0.1)
            except queue.Empty:
                continue
