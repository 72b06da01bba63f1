"""What browsers cost the server, and whether many of them for minutes lose anything."""

from __future__ import annotations

import os
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from rehab_app.access import CONSOLE
from robot_iface.link import MotionClient
from sessions.records.topics import ROBOT_STATE
from sessions.store import SessionReader, verify

from .clinic_under_load import Served, served

pytestmark = pytest.mark.bench

MINUTES = float(os.environ.get("REHAB_BENCH_MINUTES", "5"))
WINDOW_S = 10.0
MANY = 20


def resident_mb() -> float:
    """Memory of this process, the server's, MB."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


def load(here: Served, browsers: int) -> float:
    """Share of one core that the server takes while a session is played and looked at."""
    with here.looked_at(browsers):
        time.sleep(3.0)
        cpu_s, wall_s = time.process_time(), time.monotonic()
        time.sleep(WINDOW_S)
        return (time.process_time() - cpu_s) / (time.monotonic() - wall_s)


def test_five_browsers_cost_little_more_than_one(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with served(tmp_path / "clinic") as here:
        here.play()
        with here.operated():
            one, five = load(here, 1), load(here, 5)
            again = load(here, 1)
        here.stop()
    one = (one + again) / 2
    with capsys.disabled():
        sys.stdout.write(
            f"\nserver, share of a core: 1 browser {100 * one:.0f} %, 5 browsers {100 * five:.0f} % "
            f"(must: <= {100 * (1.25 * one + 0.1):.0f} %)\n"
        )
    assert five < 3.0 * one + 0.3


def test_many_browsers_for_minutes_lose_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    beats: list[int] = []
    beat = MotionClient.beat

    def beating(client: MotionClient) -> None:
        beats.append(time.monotonic_ns())
        beat(client)

    monkeypatch.setattr(MotionClient, "beat", beating)
    with served(tmp_path / "clinic") as here, here.looked_at(MANY, read_s=0.03) as figures:
        here.play()
        beats.clear()
        memory: list[float] = []
        worst_ms = 0.0
        with here.operated():
            end_s = time.monotonic() + 60.0 * MINUTES
            while time.monotonic() < end_s:
                time.sleep(2.0)
                memory.append(resident_mb())
                shown = here.clinic.live.snapshot()
                worst_ms = 1e-6 * float(np.diff(beats).max())
                assert shown.state == "playing", f"{shown.message} (worst heartbeat {worst_ms:.0f} ms)"
                if shown.paused:
                    here.clinic.live.controls.resume(CONSOLE)
        here.stop()
        row = here.clinic.sessions.list()[0]
        verify(row.path)
        with SessionReader(row.path) as reader:
            rows = reader.columns(ROBOT_STATE)
            t_ns = np.asarray(rows["t_ns"], dtype=np.int64).ravel()
    steps = np.unique(np.diff(np.sort(t_ns)))
    settled, last = memory[len(memory) // 3], memory[-1]
    with capsys.disabled():
        sys.stdout.write(
            f"\n{MANY} browsers, {MINUTES:g} min: {t_ns.size} rows, steps {steps.tolist()[:4]} ns; "
            f"worst heartbeat {worst_ms:.0f} ms of 250; "
            f"memory {settled:.0f} MB after a third, {last:.0f} MB at the end; "
            f"{min(one['pictures'] for one in figures) if figures else 0} picture messages at the slowest\n"
        )
    assert last < 1.1 * settled + 30.0
