"""How the server ends: SIGTERM in the middle of therapy stops, seals, and exits 0; systemd hears of it."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys

import pytest

from rehab_app.access import CONSOLE
from rehab_app.bootstrap import open_clinic
from rehab_app.services.tally import ENDING
from rehab_app.web.notify import ALIVE, READY, STOPPING, notify, watchdog_s
from rehab_app.web.server import ends_on_terminate
from sessions.store import partials

SCRIPT = """
import sys, threading, time
from pathlib import Path
from rehab_app.access import CONSOLE
from rehab_app.bootstrap import open_clinic
from rehab_app.services.order import Order
from rehab_app.web import serve
from rehab_app.web.server import ends_on_terminate

def play(clinic):
    clinic.live.start_therapy(CONSOLE, None, sys.argv[2], Order(speed=0.5, repetitions=1))
    shown = clinic.live.snapshot
    while shown().phase != "move" and shown().state in ("rehearsing", "playing"):
        clinic.live.operator_beat()
        time.sleep(0.05)
    print(shown().state, flush=True)
    while True:
        clinic.live.operator_beat()
        time.sleep(0.2)

with ends_on_terminate(), open_clinic(Path(sys.argv[1]), serving=True) as clinic:
    ready = lambda: threading.Thread(target=play, args=(clinic,), daemon=True).start()
    serve(clinic, port=int(sys.argv[3]), ready=ready)
    print("closing", flush=True)
    sys.stdin.readline()
"""
PATIENCE_S = 120.0


@pytest.fixture
def manager(tmp_path):
    """What systemd listens on."""
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as line:
        line.bind(str(tmp_path / "notify"))
        line.settimeout(PATIENCE_S)
        yield line


def test_terminate_in_therapy_stops_seals_and_exits_with_0(tmp_path, manager):
    folder = tmp_path / "clinic"
    with open_clinic(folder) as clinic:
        clinic.takes.record_virtual("open_close", "right", 1.5, 3, CONSOLE)
        take = clinic.takes.list()[0].id
        clinic.takes.approve(take, CONSOLE)
        before = len(clinic.catalogue.sessions())
    with socket.create_server(("127.0.0.1", 0)) as probe:
        port = probe.getsockname()[1]
    systemd = {"NOTIFY_SOCKET": manager.getsockname(), "WATCHDOG_USEC": "600000000"}
    with subprocess.Popen(
        [sys.executable, "-c", SCRIPT, str(folder), take, str(port)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        env=os.environ | systemd | {"OPENBLAS_NUM_THREADS": "1"},
    ) as server:
        try:
            assert server.stdout.readline().strip() == "playing"
            server.send_signal(signal.SIGTERM)
            assert server.stdout.readline().strip() == "closing"
            server.send_signal(signal.SIGTERM)  # somebody is impatient: the sealing goes on
            server.stdin.write("go on\n")
            server.stdin.close()
            assert server.wait(PATIENCE_S) == 0
        finally:
            server.kill()
    assert not partials(folder / "sessions")
    with open_clinic(folder) as clinic:
        assert len(clinic.catalogue.sessions()) == before + 1
        assert (ENDING, "stop") in {(row.actor, row.verb) for row in clinic.catalogue.audit()}
        assert clinic.catalogue.verify_audit() > 0
    told = heard(manager)
    assert told[0] == READY
    assert ALIVE in told
    assert STOPPING in told


def heard(manager):
    manager.setblocking(False)
    told = []
    while True:
        try:
            told.append(manager.recv(256).decode())
        except BlockingIOError:
            return told


def test_without_a_service_manager_nothing_is_told():
    assert not notify(READY, {})
    assert not notify(READY, {"NOTIFY_SOCKET": "relative"})
    assert not notify(READY, {"NOTIFY_SOCKET": "/nowhere/at/all"})


def test_a_socket_with_an_abstract_name():
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as line:
        name = f"rehab-app-{os.getpid()}"
        line.bind(f"\0{name}")
        assert notify(STOPPING, {"NOTIFY_SOCKET": f"@{name}"})
        assert line.recv(64) == STOPPING.encode()


def test_the_sign_of_life_is_given_twice_in_its_time():
    assert watchdog_s({}) == 0.0
    assert watchdog_s({"WATCHDOG_USEC": "30000000"}) == 15.0
    assert watchdog_s({"WATCHDOG_USEC": "30000000", "WATCHDOG_PID": str(os.getpid())}) == 15.0
    assert watchdog_s({"WATCHDOG_USEC": "30000000", "WATCHDOG_PID": "1"}) == 0.0
    assert watchdog_s({"WATCHDOG_USEC": "soon"}) == 0.0


def test_terminate_is_as_before_afterwards():
    before = signal.getsignal(signal.SIGTERM)
    with pytest.raises(KeyboardInterrupt), ends_on_terminate():
        signal.raise_signal(signal.SIGTERM)
    assert signal.getsignal(signal.SIGTERM) is before
