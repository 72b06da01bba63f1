"""A served clinic with a take to play, and browsers that look on from a process of their own."""

from __future__ import annotations

import json
import subprocess
import sys
import threading
import time
from collections.abc import Generator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from rehab_app.access import CONSOLE
from rehab_app.bootstrap import open_clinic
from rehab_app.errors import Refused
from rehab_app.services.clinic import Clinic
from rehab_app.services.order import Order
from rehab_app.services.rows import PreparedPlan
from rehab_app.services.snapshot import LiveSnapshot
from rehab_app.services.therapy import Therapy
from rehab_app.web import create_app
from rehab_app.web.heap import keep_heap_small
from rehab_app.web.server import ShellServer, ahead_of_others, listen
from rehab_app.web.visit import COOKIE
from robot_iface.types import Certificate

NAME = "therapist"
_BROWSERS = Path(__file__).parents[1] / "slow_browsers.py"
PATIENCE_S = 120.0


@dataclass(frozen=True, slots=True)
class Served:
    """A clinic and its real server.

    Attributes:
        clinic: The clinic.
        host: Name and port.
        site: The site of the application.
        take: Catalogue id of an approved take.
    """

    clinic: Clinic
    host: str
    site: Any
    take: str

    def sign_in(self) -> tuple[str, str]:
        """Cookie header and form token of a new sign-in."""
        issued = self.site.begin(NAME)
        return f"{COOKIE}={issued}", self.site.seal.form_token(self.site.seal.read(issued))

    def until(self, wanted: str) -> LiveSnapshot:
        """Wait for a state of the desk; the operator's page beats meanwhile."""
        end_s = time.monotonic() + PATIENCE_S
        while time.monotonic() < end_s:
            shown = self.clinic.live.snapshot()
            if shown.state == wanted:
                return shown
            assert shown.state != "failed", shown.message
            self.clinic.live.operator_beat()
            time.sleep(0.02)
        raise AssertionError(f"never {wanted}: {self.clinic.live.snapshot()}")

    def play(self, minutes: float = 0.0) -> None:
        """Play without an end in sight, and wait until it moves."""
        order = Order(speed=0.5, repetitions=500, minutes=minutes, realtime=True)
        self.clinic.live.start_therapy(CONSOLE, None, self.take, order)
        self.until("playing")

    def stop(self) -> None:
        """Stop, wait until it is sealed, clear."""
        self.clinic.live.press_stop("bench")
        end_s = time.monotonic() + PATIENCE_S
        while time.monotonic() < end_s:
            try:
                self.clinic.live.clear_stop(CONSOLE, confirmed=True)
            except Refused:  # still braking and sealing
                time.sleep(0.05)
            else:
                return
        raise AssertionError("the stop could never be cleared")

    @contextmanager
    def operated(self) -> Generator[None]:
        """An operator's page that beats five times a second."""
        ended = threading.Event()

        def beat() -> None:
            while not ended.wait(0.2):
                self.clinic.live.operator_beat()

        thread = threading.Thread(target=beat, daemon=True)
        thread.start()
        try:
            yield
        finally:
            ended.set()
            thread.join()

    @contextmanager
    def looked_at(self, browsers: int, read_s: float = 0.0) -> Generator[list[dict[str, Any]]]:
        """Browsers in a process of their own; their figures once it is over."""
        figures = list[dict[str, Any]]()
        issued = [self.sign_in() for _ in range(browsers)]
        asked = {
            "host": self.host,
            "read_s": read_s,
            "browsers": [{"cookie": cookie, "token": token} for cookie, token in issued],
        }
        command = ["nice", "-n", "10", sys.executable, str(_BROWSERS)]  # as on a machine of their own
        with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
            assert process.stdin is not None
            assert process.stdout is not None
            process.stdin.write(json.dumps(asked) + "\n")
            process.stdin.flush()
            yield figures
            process.stdin.write("\n")
            process.stdin.flush()
            figures += json.loads(process.stdout.read())


@contextmanager
def rehearsed_once() -> Generator[None]:
    """Sessions of one plan share its certificate, which the motion process checks before each of them.

    A rehearsal is a dry run of the whole session: a hundred take most of an hour, and are no part of a stop.
    """
    known: dict[str, Certificate] = {}
    rehearse = Therapy.rehearse

    def once(therapy: Therapy, prepared: PreparedPlan, **given: Any) -> Certificate:
        if prepared.binding not in known:
            known[prepared.binding] = rehearse(therapy, prepared, **given)
        return known[prepared.binding]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Therapy, "rehearse", once)
        yield


@contextmanager
def served(folder: Path) -> Generator[Served]:
    """A clinic with an approved take on its real server."""
    keep_heap_small()
    with ahead_of_others(), open_clinic(folder, serving=True) as clinic:
        clinic.accounts.add_user(NAME, "therapist", "correct horse battery", CONSOLE)
        take = clinic.takes.record_virtual("open_close", "right", 4.0, 3, CONSOLE).take
        clinic.takes.approve(take, CONSOLE)
        app, line, ready = create_app(clinic), listen("127.0.0.1", 0), threading.Event()
        server = ShellServer(app, ready.set)
        thread = threading.Thread(target=server.run, kwargs={"sockets": [line]})
        thread.start()
        assert ready.wait(60.0)
        try:
            yield Served(clinic, f"127.0.0.1:{line.getsockname()[1]}", app.state.site, take)
        finally:
            clinic.live.press_stop("bench")
            server.should_exit = True
            thread.join()
            line.close()
