"""A live camera whose driver runs in a process of its own, so that it can end or hang without the clinic."""

from __future__ import annotations

import json
import os
import socket
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from multiprocessing.connection import Connection
from types import TracebackType

from rehab_app.cameras.apart_line import Line, Opened
from rehab_app.cameras.frame import Camera, Capture, Frame, Outage
from rehab_app.cameras.lost import CameraLost, closed
from rehab_app.geometry.pinhole import Intrinsics
from sessions.errors import Refused

PATIENCE_S = 20.0
"""How long a driver may take to open its camera, and how long it may then say nothing at all."""
_SILENT_S = 2.0
_SAY_EVERY_S = 0.5
_FAREWELL_S = 4.0


class Apart:
    """A camera that is read by a process of its own.

    A driver that brings its process down, or hangs, loses the camera and nothing else: ``frames`` then
    raises ``CameraLost``, and opening it anew starts a new process. Images cross a socket: see
    ``docs/cameras.md`` for what that costs.

    Args:
        camera: The same camera, never opened here: what is known of it before it is open.
        command: Starts the process; the number of its end of the socket takes the place of ``{}``.
        patience_s: How long the driver may say nothing, s.
    """

    def __init__(self, camera: Camera, command: Sequence[str], patience_s: float = PATIENCE_S) -> None:
        self._camera = camera
        self._command = command
        self._patience_s = patience_s
        self._opened: Opened | None = None
        self._line: Line | None = None
        self._process: subprocess.Popen[bytes] | None = None

    @property
    def name(self) -> str:
        """What a session file calls this source."""
        return self._camera.name

    @property
    def intrinsics(self) -> Intrinsics:
        """Camera of the colour image.

        Raises:
            Refused: The camera was never open and does not know it before.
        """
        return self._camera.intrinsics if self._opened is None else self._opened.intrinsics

    @property
    def rate_hz(self) -> float:
        """Nominal frames per second."""
        return self._camera.rate_hz if self._opened is None else self._opened.rate_hz

    @property
    def has_depth(self) -> bool:
        """Whether frames carry depth."""
        return self._camera.has_depth

    def __enter__(self) -> Apart:
        """Start the process and have it open the camera.

        Raises:
            Refused: As the camera's own, or its driver ends or does not answer.
        """
        self._line = self._start()
        try:
            self._opened = self._answer(self._line)
        except BaseException:
            self.__exit__(None, None, None)
            raise
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Hang up; the process closes the camera and ends, or is ended."""
        line, self._line = self._line, None
        process, self._process = self._process, None
        if line is not None:
            line.close()
        if process is not None:
            _ended(process)

    def frames(self) -> Iterator[Capture]:
        """Frames as they come; an outage twice a second while the driver says nothing.

        Raises:
            Refused: The camera is not open.
            CameraLost: It gives nothing any more, or its driver has ended or hangs.
        """
        line = self._line
        if line is None:
            raise closed()
        heard_s = time.monotonic()
        while self._line is line:
            said = self._next(line, heard_s)
            if said is not None:
                heard_s = time.monotonic()
                yield said
            elif time.monotonic() - heard_s > _SILENT_S:
                yield Outage(time.monotonic_ns(), f"The camera {self.name} gives nothing: is it plugged in?")

    def _next(self, line: Line, heard_s: float) -> Frame | Outage | None:
        """The next capture; None if none came within half a second."""
        try:
            if not line.hears_within(_SAY_EVERY_S):
                if time.monotonic() - heard_s > self._patience_s:
                    raise CameraLost(f"The driver of the camera {self.name} hangs: plug the camera in again.")
                return None
            said = line.hear()
        except (EOFError, OSError):
            if self._line is not line:
                return None  # closed meanwhile
            raise CameraLost(
                f"The driver of the camera {self.name} failed: plug the camera in again."
            ) from None
        if isinstance(said, Refused | CameraLost):
            raise said
        return None if isinstance(said, Opened) else said

    def _answer(self, line: Line) -> Opened:
        """What the process says once the camera is open."""
        try:
            if not line.hears_within(self._patience_s):
                raise self._unusable(f"without an answer for {self._patience_s:g} s")
            said = line.hear()
        except (EOFError, OSError):
            raise self._unusable("ended by its driver") from None
        if isinstance(said, Opened):
            return said
        raise said if isinstance(said, Refused) else self._unusable("gone")

    def _unusable(self, met: str) -> Refused:
        return Refused(f"camera {self.name}", met, "ready", "plug it in again, then try again")

    def _start(self) -> Line:
        ours, theirs = socket.socketpair()
        with theirs:
            words = [word.replace("{}", str(theirs.fileno())) for word in self._command]
            self._process = subprocess.Popen(
                words,
                pass_fds=(theirs.fileno(),),
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                start_new_session=True,  # Ctrl-C in a terminal is for the recording, which then closes it
                env={**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"},
            )
        return Line(Connection(ours.detach()))


def reading(spec: str, intrinsics: Intrinsics | None) -> tuple[str, ...]:
    """The command that reads the live camera of a name, with its intrinsics if they are known."""
    lens = json.dumps(None if intrinsics is None else asdict(intrinsics))
    return (sys.executable, "-P", "-m", "rehab_app.cameras.apart_reader", "{}", spec, lens)


def _ended(process: subprocess.Popen[bytes]) -> None:
    """Wait for a process that was hung up on; one whose driver never returns is killed."""
    try:
        process.wait(_FAREWELL_S)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
