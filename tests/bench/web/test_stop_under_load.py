"""The stop while five browsers look on and reports render: from the browser to the latched tick."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
import time
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from robot_iface.link import MotionClient

from .clinic_under_load import Served, served

pytestmark = pytest.mark.bench

PRESSES = int(os.environ.get("REHAB_BENCH_PRESSES", "20"))
VIEWERS = 5


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
    script = Path(__file__).with_name("presser.py")
    with subprocess.Popen(
        [sys.executable, str(script)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
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


def test_the_stop_and_the_heartbeat_under_load(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    latched: dict[int, int] = {}
    pressed_ns: list[int] = []
    beats: list[int] = []
    close, beat, press = MotionClient.close, MotionClient.beat, MotionClient.press_stop

    def pressing(client: MotionClient) -> None:
        pressed_ns.append(time.monotonic_ns())
        press(client)

    def closing(client: MotionClient) -> None:
        if client.pid not in latched:
            waited_ns = client.stop_latency_ns()
            latched[client.pid] = 0 if waited_ns is None else pressed_ns[0] + waited_ns
        close(client)

    def beating(client: MotionClient) -> None:
        beats.append(time.monotonic_ns())
        beat(client)

    monkeypatch.setattr(MotionClient, "close", closing)
    monkeypatch.setattr(MotionClient, "press_stop", pressing)
    monkeypatch.setattr(MotionClient, "beat", beating)
    waits_ms: list[float] = []
    gaps_ms: list[float] = []
    with served(tmp_path / "clinic") as here, here.looked_at(VIEWERS), reports_render(here):
        with presser(here) as process:
            for number in range(PRESSES):
                here.play()
                beats.clear()
                pressed_ns.clear()
                with here.operated():
                    time.sleep(1.0 + 0.037 * number)
                known = len(latched)
                gaps_ms += list(1e-6 * np.diff(beats))
                at_ns, _ = pressed(process)
                here.stop()
                assert len(latched) == known + 1
                latched_ns = latched[list(latched)[-1]]
                assert latched_ns > 0, "the run had ended by itself before the press"
                waits_ms.append(1e-6 * (latched_ns - at_ns))
    p50, p99 = np.percentile(waits_ms, [50, 99])
    with capsys.disabled():
        sys.stdout.write(
            f"\nstop with {VIEWERS} browsers and reports, browser to latched tick, {PRESSES} presses: "
            f"p50 {p50:.1f} ms, p99 {p99:.1f} ms, worst {max(waits_ms):.1f} ms (must: p99 50 ms)\n"
            f"heartbeat of the app (bound 250 ms): p99 {np.percentile(gaps_ms, 99):.0f} ms, "
            f"worst gap {max(gaps_ms):.0f} ms of {len(gaps_ms)}\n"
        )
    assert max(waits_ms) > 0.0
