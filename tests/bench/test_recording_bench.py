"""A long recording with five slow browsers looking on: not one capture may be lost between camera and file.

Sixty seconds by default; ``REHAB_SOAK_S=600`` is the ten minutes that the product promises. The browsers
speak to the real server over real sockets. It needs a machine that does nothing else.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rehab_app.access import CONSOLE
from rehab_app.bootstrap import open_clinic
from rehab_app.services.clinic import Clinic
from rehab_app.web import create_app
from rehab_app.web.server import ShellServer, listen
from rehab_app.web.visit import COOKIE
from sessions.records import Status
from sessions.records.topics import MARKERS
from sessions.store import SessionReader, verify

pytestmark = pytest.mark.bench

SECONDS = float(os.environ.get("REHAB_SOAK_S", "60"))
BROWSERS = 5
RATE_HZ = 30.0


@contextmanager
def served(clinic: Clinic) -> Iterator[tuple[str, Any]]:
    """The clinic's real server on a port of its own."""
    app = create_app(clinic)
    line = listen("127.0.0.1", 0)
    ready = threading.Event()
    server = ShellServer(app, ready.set)
    thread = threading.Thread(target=server.run, kwargs={"sockets": [line]})
    thread.start()
    assert ready.wait(30.0)
    try:
        yield f"127.0.0.1:{line.getsockname()[1]}", app
    finally:
        server.should_exit = True
        thread.join()
        line.close()


@contextmanager
def looked_at(host: str, app: Any) -> Iterator[list[dict[str, Any]]]:
    """Five browsers in a process of their own; their figures once it is over."""
    seal, figures = app.state.site.seal, list[dict[str, Any]]()
    issued = [app.state.site.begin("therapist") for _ in range(BROWSERS)]
    asked = [{"cookie": f"{COOKIE}={one}", "token": seal.form_token(seal.read(one))} for one in issued]
    script = Path(__file__).with_name("slow_browsers.py")
    with subprocess.Popen(
        [sys.executable, str(script)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdin is not None
        assert process.stdout is not None
        process.stdin.write(json.dumps({"host": host, "browsers": asked}) + "\n")
        process.stdin.flush()
        yield figures
        process.stdin.write("\n")
        process.stdin.flush()
        figures += json.loads(process.stdout.read())


def test_no_capture_is_lost_however_slow_the_browsers(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with ExitStack() as opened:
        clinic = opened.enter_context(open_clinic(tmp_path / "clinic"))
        clinic.accounts.add_user("therapist", "therapist", "correct horse battery", CONSOLE)
        host, app = opened.enter_context(served(clinic))
        with looked_at(host, app) as figures:
            clinic.live.start_recording(CONSOLE, "open_close", "right", SECONDS, countdown_s=3.0, seed=11)
            cpu_s, end_s = time.process_time(), time.monotonic() + SECONDS + 60.0
            while clinic.live.snapshot().state not in ("done", "failed") and time.monotonic() < end_s:
                time.sleep(0.5)
            done = clinic.live.snapshot()
            cpu_s = time.process_time() - cpu_s
        assert done.state == "done", done.message
        row = clinic.takes.get(done.take_id)
        verify(row.path)
        with SessionReader(row.path) as reader:
            columns = reader.columns(MARKERS)
            t_ns, status = columns.t_ns, columns["status"]
    polls_ms = 1e3 * np.concatenate([one["polls_s"] for one in figures])
    pictures = sum(one["pictures"] for one in figures)
    with capsys.disabled():
        sys.stdout.write(
            f"\n{SECONDS:g} s with {BROWSERS} browsers: {len(t_ns)} captures in the file, "
            f"{done.dropped} lost, {100 * np.mean(status == Status.MEASURED):.1f} % measured; a poll took "
            f"{np.median(polls_ms):.0f} ms, 99 % below {np.quantile(polls_ms, 0.99):.0f} ms; "
            f"{pictures} messages of the picture were read; camera, perception, file and server took "
            f"{1e3 * cpu_s / len(t_ns):.1f} ms of one core for each capture\n"
        )
    number = (t_ns - t_ns[0]) * 1e-9 * RATE_HZ
    assert done.dropped == 0
    assert len(t_ns) == int(SECONDS * RATE_HZ) + 1
    assert np.abs(number - np.arange(len(t_ns))).max() < 1e-3
    assert min(len(one["polls_s"]) for one in figures) > SECONDS
    assert min(one["pictures"] for one in figures) > 0
