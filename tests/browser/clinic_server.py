"""The real command ``rehab-app serve`` as a process that a test opens, kills and opens again."""

from __future__ import annotations

import socket
import subprocess
import sys
import time
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path

OPENS_S = 60.0


class ClinicServer:
    """A server of one clinic folder at one port.

    Args:
        folder: The clinic folder.
        port: Its port on loopback; by default a free one.
    """

    def __init__(self, folder: Path, port: int = 0) -> None:
        with socket.create_server(("127.0.0.1", port)) as probe:
            self.port: int = probe.getsockname()[1]
        self.folder = folder
        self.address = f"http://localhost:{self.port}"
        self._log = folder / "server.log"
        self._process: subprocess.Popen[bytes] | None = None

    def open(self) -> None:
        """Start it and wait until it answers browsers."""
        words = [sys.executable, "-m", "rehab_app", "serve", "--data", str(self.folder)]
        with self._log.open("wb") as log:
            self._process = subprocess.Popen(
                [*words, "--port", str(self.port)], stdout=subprocess.DEVNULL, stderr=log
            )
        end_s = time.monotonic() + OPENS_S
        while "is open at" not in self.log():
            assert self._process.poll() is None, self.log()
            assert time.monotonic() < end_s, "the server did not open within a minute"
            time.sleep(0.05)

    def kill(self) -> None:
        """End it as a power cut would: nothing is told, nothing is sealed."""
        assert self._process is not None
        self._process.kill()
        self._process.wait(timeout=30)

    def close(self) -> None:
        """End it as Ctrl-C would."""
        assert self._process is not None
        self._process.terminate()
        self._process.wait(timeout=60)

    def log(self) -> str:
        """What it said since it was opened."""
        return self._log.read_text(encoding="utf-8")


@contextmanager
def serving(folder: Path) -> Generator[ClinicServer]:
    """A server until the end of the block; its log must hold no traceback."""
    server = ClinicServer(folder)
    try:
        server.open()
        yield server
    finally:
        server.close()
    assert "Traceback" not in server.log(), server.log()
