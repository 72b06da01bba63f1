"""Work done in order on a thread behind the caller, who waits only when too much has piled up."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor

MOST_WAITING = 150  # five seconds of frames at 30 Hz


class Behind:
    """Runs pieces of work one after the other; what one of them raises is raised at the next call.

    Args:
        most: Pieces that may wait before the caller does.
    """

    def __init__(self, most: int = MOST_WAITING) -> None:
        self._most = most
        self._pool = ThreadPoolExecutor(1, thread_name_prefix="behind")
        self._waiting: deque[Future[None]] = deque()

    def do(self, work: Callable[[], None]) -> None:
        """Queue a piece of work."""
        while self._waiting and (self._waiting[0].done() or len(self._waiting) >= self._most):
            self._waiting.popleft().result()
        self._waiting.append(self._pool.submit(work))

    def finish(self) -> None:
        """Wait until all is done."""
        while self._waiting:
            self._waiting.popleft().result()

    def close(self) -> None:
        """End the thread; what still waits is dropped, what runs is waited for. Twice does no harm."""
        self._pool.shutdown(wait=True, cancel_futures=True)
