"""Records a take in real time, with a countdown, and shows it on the live board."""

from __future__ import annotations

import threading
import time
from dataclasses import dataclass

from rehab_app.access import Account
from rehab_app.cameras import Outage
from rehab_app.errors import Refused
from rehab_app.recording.live_pose import LivePose
from rehab_app.services.live_board import Board
from rehab_app.services.picture_maker import PictureMaker
from rehab_app.services.recording_request import RecordingRequest
from rehab_app.services.replay import replay_of
from rehab_app.services.take_sources import Listeners
from rehab_app.services.takes import Takes

LONGEST_COUNTDOWN_S = 30.0
_STEP_S = 0.1
_MOST_NAMED = 12


@dataclass(frozen=True, slots=True)
class RecordingOrder:
    """What to record.

    Attributes:
        actor: Who records.
        request: What.
        countdown_s: Seconds before it begins.

    Raises:
        Refused: The countdown is out of bounds.
    """

    actor: Account
    request: RecordingRequest
    countdown_s: float

    def __post_init__(self) -> None:
        if not 0.0 <= self.countdown_s <= LONGEST_COUNTDOWN_S:
            bound = f"0 to {LONGEST_COUNTDOWN_S:g} s"
            raise Refused("countdown", f"{self.countdown_s:g} s", bound, "choose a shorter countdown")


class RecordingJob:
    """One recording on its own thread."""

    def __init__(self, board: Board, takes: Takes, order: RecordingOrder) -> None:
        self._board = board
        self._takes = takes
        self._order = order
        self._finish = threading.Event()
        self._pictures = PictureMaker(board)

    def stop(self) -> None:
        """Stop was pressed: nothing moves here, but the recording ends and keeps what there is."""
        self._finish.set()

    def finish(self) -> None:
        """End the recording and keep what there is."""
        self._finish.set()

    def run(self) -> None:
        """Count down, record, seal.

        Raises:
            Refused: The camera cannot be used, no hand was seen, or the take came out shorter than 1 s.
        """
        order = self._order
        end_s = time.monotonic() + order.countdown_s
        while (left_s := end_s - time.monotonic()) > 0 and not self._finish.is_set():
            self._board.update(countdown_s=left_s)
            self._finish.wait(min(_STEP_S, left_s))
        if self._finish.is_set():
            self._board.update(state="idle", message="The recording was called off.", countdown_s=0.0)
            return
        self._board.update(state="recording", message="Opening the camera.", countdown_s=0.0)
        listeners = Listeners(self._show, self._show_outage, self._finish.is_set)
        with self._pictures:
            summary = self._takes.record(order.request, order.actor, listeners=listeners)
        found = replay_of(summary.path).repetitions_s
        counted = f"{len(found)} repetition{'' if len(found) == 1 else 's'}"
        self._board.update(
            state="done",
            message=f"Take {summary.take} recorded ({summary.duration_s:.1f} s, {counted}). "
            "Look at it and approve it.",
            take_id=summary.take,
            notes=tuple(
                f"Repetition {number}: {begin_s:.1f} to {end_s:.1f} s."
                for number, (begin_s, end_s) in enumerate(found[:_MOST_NAMED], start=1)
            ),
        )

    def _show(self, live: LivePose) -> None:
        """Publish one frame; its picture is made elsewhere, of the newest frame only."""
        shown = {} if live.geometry is None else {"geometry": live.geometry}
        self._board.picture(
            t_s=live.t_s,
            therapist_joints_rad=live.joints_rad,
            tracking_quality=live.quality,
            estimated_share=live.estimated,
            lost_share=live.lost,
            dropped=live.dropped,
            message=_sentence(live),
            state="processing" if self._finish.is_set() else "recording",
            **shown,
        )
        self._pictures.show(live)

    def _show_outage(self, outage: Outage) -> None:
        """Say that the camera gives nothing; no frame is counted, so that the picture goes stale."""
        self._board.update(message=outage.reason, tracking_quality=0.0, therapist_joints_rad=None)


_STATES = {
    "searching": "Looking for an open hand: hold it still, all markers towards the camera.",
    "calibrating": "Learning the hand: keep it open and still.",
    "tracking": "Recording.",
    "lost": "The hand is lost: show it open to the camera.",
}


def _sentence(live: LivePose) -> str:
    """What the person at the screen should know now."""
    if live.fault:
        return live.fault
    return live.complaint or _STATES[live.state]
