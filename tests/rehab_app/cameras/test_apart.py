"""A driver that crashes or hangs loses its camera, and nothing else."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from itertools import islice

import pytest

from rehab_app.cameras import Frame, Outage, Reconnecting, apart
from rehab_app.cameras.apart import Apart
from rehab_app.cameras.lost import CameraLost
from rehab_app.cameras.webcam import Webcam
from rehab_app.geometry.pinhole import Intrinsics
from sessions.errors import Refused

LENS = Intrinsics(50.0, 50.0, 31.5, 23.5, 64, 48)
CHILD = """
import os, sys, threading, time
from multiprocessing.connection import Connection
import numpy as np
from rehab_app.cameras import Frame, Outage
from rehab_app.cameras.apart_reader import read
from rehab_app.cameras.lost import CameraLost, absent
from rehab_app.geometry.pinhole import Intrinsics
def hang():
    threading.Event().wait()
class Driver:
    name, has_depth, rate_hz, intrinsics = "webcam", False, 10.0, Intrinsics(50.0, 50.0, 31.5, 23.5, 64, 48)
    def __enter__(self):
        OPENS
    def __exit__(self, *told):
        CLOSES
    def frames(self):
        for index in range(3):
            image = np.full((48, 64, 3), index, np.uint8)
            yield Frame(time.monotonic_ns(), image, None, self.intrinsics, os.getpid())
        GIVES
read(Driver(), Connection(int(sys.argv[1])))
"""
"""A driver whose first three frames hold the number of its process where others count what was lost."""


def driver(
    opens: str = "pass", gives: str = "hang()", closes: str = "pass", patience_s: float = 20.0
) -> Apart:
    program = CHILD.replace("OPENS", opens).replace("GIVES", gives).replace("CLOSES", closes)
    return Apart(Webcam(0, LENS), (sys.executable, "-c", program, "{}"), patience_s)


def ends(process: int) -> bool:
    """Whether a process ends soon; one that has ended and waits for its parent's word has, too."""
    end_s = time.monotonic() + 20.0
    while time.monotonic() < end_s:
        try:
            with open(f"/proc/{process}/stat") as stat:
                if stat.read().rpartition(")")[2].split()[0] == "Z":
                    return True
        except OSError:
            return True
    return False


@pytest.mark.parametrize("dies", ["os.abort()", "os.kill(os.getpid(), 9)", "raise KeyError"])
def test_a_driver_that_crashes_loses_the_camera(dies: str) -> None:
    met = []
    with driver(gives=dies) as camera, pytest.raises(CameraLost, match="webcam failed: plug the camera in"):
        met += camera.frames()
    assert len(met) == 3


def test_one_that_crashes_is_started_again_and_what_was_lost_is_counted() -> None:
    with Reconnecting(lambda: driver(gives="os.abort()")) as camera:
        captures = list(islice(camera.frames(), 7))
    kinds = [isinstance(one, Frame) for one in captures]
    assert kinds == [True] * 3 + [False] + [True] * 3
    back = captures[4]
    assert isinstance(back, Frame)
    assert 4 <= back.dropped < 1000  # half a second at 10 Hz at least, and no number of a process


def test_a_driver_that_hangs_is_said_and_then_given_up(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(apart, "_SAY_EVERY_S", 0.05)
    monkeypatch.setattr(apart, "_SILENT_S", 0.1)
    met = []
    with driver(gives="hang()") as camera:
        monkeypatch.setattr(camera, "_patience_s", 0.5)
        with pytest.raises(CameraLost, match="hangs: plug the camera in"):
            met += camera.frames()
    assert sum(isinstance(one, Frame) for one in met) == 3
    outages = [one for one in met if isinstance(one, Outage)]
    assert 2 <= len(outages) <= 10
    assert outages[0].reason == "The camera webcam gives nothing: is it plugged in?"


@pytest.mark.parametrize(
    ("opens", "patience_s", "sentence"),
    [
        ("os.abort()", 20.0, "ended by its driver"),
        ("hang()", 0.5, "without an answer for 0.5 s"),
        ("raise CameraLost('It went.')", 20.0, "gone"),
        ("raise absent('camera webcam:3')", 20.0, "camera webcam:3 is not found"),
    ],
)
def test_a_driver_that_cannot_open_is_a_sentence(opens: str, patience_s: float, sentence: str) -> None:
    with pytest.raises(Refused, match=sentence):
        driver(opens=opens, patience_s=patience_s).__enter__()


@pytest.mark.parametrize("closes", ["pass", "hang()", "os.abort()"])
def test_no_process_is_left(closes: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(apart, "_FAREWELL_S", 0.5)
    with driver(closes=closes) as camera:
        first = next(camera.frames())
    assert isinstance(first, Frame)
    assert ends(first.dropped)


def test_a_process_ends_with_the_one_that_it_reads_for() -> None:
    """Also where its driver hangs: nothing keeps the camera of a server that was killed."""
    user = (
        "import sys; from itertools import islice; from tests.rehab_app.cameras.test_apart import driver\n"
        "with driver() as camera:\n"
        "    print([one.dropped for one in islice(camera.frames(), 3)][0], flush=True)\n"
        "    sys.stdin.read()\n"
    )
    with subprocess.Popen(
        [sys.executable, "-c", user], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as using:
        assert using.stdout is not None
        reading = int(using.stdout.readline())
        using.send_signal(signal.SIGKILL)
    assert ends(reading)


def test_a_terminals_interrupt_is_not_for_the_driver() -> None:
    with driver(gives="yield Outage(0, 'It rests.'); hang()") as camera:
        captures = camera.frames()
        first = next(captures)
        assert isinstance(first, Frame)
        assert os.getsid(first.dropped) != os.getsid(0)
        assert list(islice(captures, 3))[-1] == Outage(0, "It rests.")
