"""The stop while five browsers look on and reports render: from the browser to the latched tick."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
import time
from collections.abc import Generator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from robot_iface.link import MotionClient

from .clinic_under_load import Served, rehearsed_once, served

pytestmark = pytest.mark.bench

PRESSES = int(os.environ.get("REHAB_BENCH_PRESSES", "100"))
VIEWERS = 5
MUST_MS = 50.0


@contextmanager
def reports_render(here: Served) -> Generator[None]:
    """Reports, one after the other, in their own process as the pages ask for them."""
    ended = threading.Event()

    def render() -> None:
        while not ended.is_set():
            here.clinic.reports.html(here.take)

    thread = threading.Thread(target=render, daemon=True)
    thread.start()
    try:
        yield
    finally:
        ended.set()
        thread.join()


@contextmanager
def presser(here: Served) -> Generator[subprocess.Popen[str]]:
    """A browser that presses; as on a machine of its own, it waits for nobody here."""
    ahead = ["nice", "-n", "-10"] if os.geteuid() == 0 else []
    script = Path(__file__).with_name("presser.py")
    with subprocess.Popen(
        [*ahead, sys.executable, str(script)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdin is not None
        process.stdin.write(f"{here.host} {here.sign_in()[0]}\n")
        process.stdin.flush()
        yield process
        process.stdin.close()


def pressed(process: subprocess.Popen[str]) -> tuple[int, int]:
    """Press once: when it was pressed and when the answer came, monotonic ns."""
    assert process.stdin is not None
    assert process.stdout is not None
    process.stdin.write("press\n")
    process.stdin.flush()
    first, last, status = process.stdout.readline().split()
    assert status == "200"
    return int(first), int(last)


@dataclass(frozen=True, slots=True)
class Press:
    """One press of the stop.

    Attributes:
        wait_ms: From the browser's timestamp to the latched tick, 0 where the run had ended by itself before.
        heard_ms: The part of it until the server wrote the stop word.
        gaps_ms: Gaps of the app's heartbeat before it.
    """

    wait_ms: float
    heard_ms: float
    gaps_ms: list[float]


class Watched:
    """When the motion process was told of a stop and latched it, and when the app beat; monotonic ns."""

    def __init__(self, patch: pytest.MonkeyPatch) -> None:
        self.latched: list[int] = []
        self.pressed: list[int] = []
        self.beats: list[int] = []
        close, beat, press = MotionClient.close, MotionClient.beat, MotionClient.press_stop

        def closing(client: MotionClient) -> None:
            waited_ns = client.stop_latency_ns()
            self.latched.append(0 if waited_ns is None else self.pressed[0] + waited_ns)
            close(client)

        def pressing(client: MotionClient) -> None:
            self.pressed.append(time.monotonic_ns())
            press(client)

        def beating(client: MotionClient) -> None:
            self.beats.append(time.monotonic_ns())
            beat(client)

        patch.setattr(MotionClient, "close", closing)
        patch.setattr(MotionClient, "press_stop", pressing)
        patch.setattr(MotionClient, "beat", beating)

    def once(self, here: Served, process: subprocess.Popen[str], wait_s: float) -> Press:
        """Play, then press."""
        here.play()
        for heard in (self.latched, self.pressed, self.beats):
            heard.clear()
        with here.operated():
            time.sleep(wait_s)
        gaps_ms = list(1e-6 * np.diff(self.beats))
        at_ns, _ = pressed(process)
        here.stop()
        heard_ms = 1e-6 * (self.pressed[0] - at_ns)
        return Press(1e-6 * (self.latched[0] - at_ns) if self.latched[0] else 0.0, heard_ms, gaps_ms)


def test_the_stop_and_the_heartbeat_under_load(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    watched, presses, ended = Watched(monkeypatch), list[Press](), 0
    with served(tmp_path / "clinic") as here, rehearsed_once(), here.looked_at(VIEWERS), reports_render(here):
        with presser(here) as process:
            while len(presses) < PRESSES:  # at any phase of the control's ticks
                press = watched.once(here, process, 0.5 + 0.037 * (len(presses) % 20))
                if press.wait_ms:
                    presses.append(press)
                else:  # so busy a machine that the supervisor had ended the run before the press
                    ended += 1
                    assert ended <= PRESSES, "every second run ended by itself"
                with capsys.disabled():
                    sys.stdout.write(f"{len(presses)} presses, {press.wait_ms:.1f} ms\n")
    with capsys.disabled():
        sys.stdout.write(_told(presses, ended))
    assert min(press.wait_ms for press in presses) > 0.0


def _told(presses: list[Press], ended: int) -> str:
    waits_ms, heard_ms = [one.wait_ms for one in presses], [one.heard_ms for one in presses]
    gaps_ms = [gap for one in presses for gap in one.gaps_ms]
    p50, p99 = np.percentile(waits_ms, [50, 99])
    return (
        f"\nstop with {VIEWERS} browsers and reports, browser to latched tick, {len(presses)} presses: "
        f"p50 {p50:.1f} ms, p99 {p99:.1f} ms, worst {max(waits_ms):.1f} ms (must: p99 {MUST_MS:.0f} ms); "
        f"until the server wrote the stop word: p50 {np.percentile(heard_ms, 50):.1f} ms, "
        f"p99 {np.percentile(heard_ms, 99):.1f} ms; {ended} more runs had ended by themselves\n"
        f"heartbeat of the app (bound 250 ms): p99 {np.percentile(gaps_ms, 99):.0f} ms, "
        f"worst gap {max(gaps_ms):.0f} ms of {len(gaps_ms)}\n"
    )
