"""Makes the camera's picture for the pages on a thread of its own: the newest, ten times a second."""

from __future__ import annotations

import threading
from types import TracebackType

from rehab_app.recording.live_pose import LivePose
from rehab_app.services.live_board import Board

_PERIOD_S = 0.1


class PictureMaker:
    """A context manager; while it is entered, the newest frame shown becomes the board's picture.

    However slow a page or the compression is, nobody who calls ``show`` waits: older frames are passed over.

    Args:
        board: Where the picture goes.
    """

    def __init__(self, board: Board) -> None:
        self._board = board
        self._newest: LivePose | None = None
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._work, name="pictures", daemon=True)

    def __enter__(self) -> PictureMaker:
        """Start the thread."""
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """End the thread."""
        self._ended.set()
        self._thread.join()

    def show(self, live: LivePose) -> None:
        """Hand over a frame; a single attribute is written."""
        self._newest = live

    def _work(self) -> None:
        made: LivePose | None = None
        while not self._ended.wait(_PERIOD_S):
            newest = self._newest
            if newest is not None and newest is not made:
                self._board.jpeg = newest.jpeg()
                made = newest
