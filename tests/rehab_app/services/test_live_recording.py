"""Recording while slow pages look on, in simulated time: the camera's frames are the file's frames."""

from __future__ import annotations

import threading
from pathlib import Path

import numpy as np
import pytest

from rehab_app.access import CONSOLE
from rehab_app.bootstrap import open_clinic
from rehab_app.cameras import Outage
from rehab_app.errors import Refused
from rehab_app.services.live_board import Board
from rehab_app.services.live_recording import RecordingJob, RecordingOrder
from rehab_app.services.recording_request import RecordingRequest
from sessions.records.topics import MARKERS
from sessions.store import SessionReader

SECONDS = 4.0
VIEWERS = 5


def request(**more: object) -> RecordingRequest:
    return RecordingRequest(
        **{"exercise": "open_close", "side": "right", "seconds": SECONDS, "seed": 9, **more}
    )


def test_five_slow_viewers_cost_no_capture(tmp_path: Path) -> None:
    board, ended = Board(), threading.Event()
    looks: list[set[int]] = [set() for _ in range(VIEWERS)]

    def look(seen: set[int]) -> None:
        while not ended.wait(0.15):
            snapshot, picture = board.snapshot, board.jpeg
            seen.add(snapshot.frame)
            assert picture is None or picture.startswith(b"\xff\xd8")

    viewers = [threading.Thread(target=look, args=(seen,)) for seen in looks]
    for viewer in viewers:
        viewer.start()
    try:
        with open_clinic(tmp_path) as clinic:
            RecordingJob(board, clinic.takes, RecordingOrder(CONSOLE, request(), 0.0)).run()
            row = clinic.takes.get(board.snapshot.take_id)
            with SessionReader(row.path) as reader:
                t_ns = reader.columns(MARKERS).t_ns
    finally:
        ended.set()
        for viewer in viewers:
            viewer.join()
    assert board.snapshot.state == "done"
    assert board.snapshot.frame == len(t_ns) == round(SECONDS * 30) + 1
    assert np.array_equal(np.rint((t_ns - t_ns[0]) * 30e-9), np.arange(len(t_ns)))
    assert board.snapshot.dropped == 0
    assert board.snapshot.lost_share < 0.05
    assert board.jpeg is not None
    assert all(len(seen) > 1 for seen in looks)


def test_an_outage_is_the_sentence_of_the_page(tmp_path: Path) -> None:
    board = Board()
    with open_clinic(tmp_path) as clinic:
        job = RecordingJob(board, clinic.takes, RecordingOrder(CONSOLE, request(), 0.0))
        before = board.snapshot.frame
        job._show_outage(Outage(1, "The camera was unplugged: plug it in again."))
    assert board.snapshot.message == "The camera was unplugged: plug it in again."
    assert board.snapshot.tracking_quality == 0.0
    assert board.snapshot.frame == before


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"exercise": "juggling"}, "open_close"),
        ({"camera": "webcam:0", "exercise": ""}, "name the movement"),
        ({"side": "both"}, "left or right"),
        ({"seconds": 601.0}, "1 to 600 s"),
        ({"tracker": "magic"}, "kinematic, rbmcda"),
        ({"protocol": "magic"}, "thesis25"),
        ({"person": "Anna Nowak"}, "never a name"),
        ({"beside": ("virtual",)}, "named twice"),
    ],
)
def test_what_cannot_be_asked_for_is_refused(values: dict[str, object], words: str) -> None:
    with pytest.raises(Refused) as refused:
        request(**values)
    assert words in str(refused.value)


def test_a_second_camera_of_unknown_place_is_refused(tmp_path: Path) -> None:
    with open_clinic(tmp_path) as clinic, pytest.raises(Refused, match="calibrate stereo"):
        clinic.takes.record(request(beside=("webcam:3",)), CONSOLE)


def test_a_real_camera_may_record_any_movement() -> None:
    assert request(camera="webcam:0", exercise="wash hands").exercise == "wash hands"
