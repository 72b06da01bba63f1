"""Records a take from the virtual camera in real time, with a countdown."""

from __future__ import annotations

import threading
import time
from dataclasses import dataclass

from rehab_app.access import Account
from rehab_app.recording.pipeline import LivePose
from rehab_app.services.live_board import Board
from rehab_app.services.takes import Takes

_STEP_S = 0.1
_JPEG_PERIOD_S = 0.1


@dataclass(frozen=True, slots=True)
class RecordingOrder:
    """What to record.

    Attributes:
        actor: Who records.
        exercise: Exercise name.
        side: Side of the hand.
        seconds: Longest length.
        countdown_s: Seconds before it begins.
        seed: Seed of the virtual camera.
    """

    actor: Account
    exercise: str
    side: str
    seconds: float
    countdown_s: float
    seed: int


class RecordingJob:
    """One recording on its own thread."""

    def __init__(self, board: Board, takes: Takes, order: RecordingOrder) -> None:
        self._board = board
        self._takes = takes
        self._order = order
        self._finish = threading.Event()
        self._stopped = False
        self._next_jpeg_s = 0.0

    def stop(self) -> None:
        """Stop was pressed: nothing moves here, but the recording ends and keeps what there is."""
        self._stopped = True
        self._finish.set()

    def finish(self) -> None:
        """End the recording and keep what there is."""
        self._finish.set()

    def run(self) -> None:
        """Count down, record, seal.

        Raises:
            Refused: The take came out shorter than 1 s, or the recording failed.
        """
        order = self._order
        end_s = time.monotonic() + order.countdown_s
        while (left_s := end_s - time.monotonic()) > 0 and not self._finish.is_set():
            self._board.update(countdown_s=left_s)
            self._finish.wait(min(_STEP_S, left_s))
        if self._finish.is_set():
            self._board.update(state="idle", message="The recording was called off.", countdown_s=0.0)
            return
        self._board.update(state="recording", message="Recording.", countdown_s=0.0)
        summary = self._takes.record_virtual(
            order.exercise,
            order.side,
            order.seconds,
            order.seed,
            order.actor,
            realtime=True,
            on_frame=self._show,
            finished=self._finish.is_set,
        )
        self._board.update(
            state="done",
            message=f"Take {summary.take} recorded ({summary.duration_s:.1f} s). Look at it and approve it.",
            take_id=summary.take,
        )

    def _show(self, live: LivePose) -> None:
        """Publish one frame; the image at 10 Hz, which is what a page can use of it."""
        shown = {} if live.geometry is None else {"geometry": live.geometry}
        self._board.picture(
            t_s=live.t_s,
            therapist_joints_rad=live.joints_rad,
            tracking_quality=live.quality,
            state="processing" if self._finish.is_set() else "recording",
            **shown,
        )
        now_s = time.monotonic()
        if now_s >= self._next_jpeg_s:
            self._next_jpeg_s = now_s + _JPEG_PERIOD_S
            self._board.jpeg = live.jpeg()
