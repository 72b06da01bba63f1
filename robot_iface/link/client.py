"""The app's side of the link: starts the motion process, orders, listens, and can always stop it."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from types import TracebackType
from typing import Any

from robot_iface.errors import Refused
from robot_iface.link.codec import decode, encode
from robot_iface.link.messages import Cleared, Ready, Refusal, Rehearse, Start, Started
from robot_iface.link.page import SharedPage
from robot_iface.link.wire import Wire, WireClosed
from robot_iface.runtime import LiveSample, Message, Order
from robot_iface.runtime.orders import Advance, Pain, Pause, Reset, Resume, Reverse, SetSpeed
from robot_iface.types import Certificate, PhaseChange, Plan, RunEnd, SafetyEvent, TickBlock

_START_TIMEOUT_S = 60.0
_REHEARSAL_TIMEOUT_S = 600.0
_ANSWER_TIMEOUT_S = 10.0
_END_TIMEOUT_S = 5.0
_POLL_S = 0.05
_RUN_MESSAGES = (PhaseChange, SafetyEvent, TickBlock, RunEnd)


class MotionClient:
    """The motion process, from the app. A context manager.

    One thread rehearses, starts and reads ``messages``; ``press_stop``, ``beat``, ``operator_beat``, ``live``
    and the orders may be called from any thread at any time. In real time the motion process brakes when it
    has not heard ``beat`` for a quarter of a second; reading ``messages`` beats by itself.

    Raises:
        Refused: The motion process did not come up.
    """

    def __init__(self) -> None:
        self._page = SharedPage()
        ours, theirs = socket.socketpair()
        self._wire = Wire(ours)
        self._sending = threading.Lock()
        self._running = False
        self._closed = False
        self._last_words = tempfile.TemporaryFile()
        with theirs:
            self._process = self._spawn(theirs)
        try:
            self._expect(Ready, _START_TIMEOUT_S)
        except Refused:
            self.close()
            raise

    def __enter__(self) -> MotionClient:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    @property
    def pid(self) -> int:
        """Process number of the motion process."""
        return self._process.pid

    @property
    def running(self) -> bool:
        """Whether a run was started whose RunEnd has not been read yet."""
        return self._running

    @property
    def stop_pressed(self) -> bool:
        """Whether the stop word is set."""
        return self._page.pressed()

    def rehearse(self, plan: Plan) -> Certificate:
        """Rehearse a plan in the motion process.

        Raises:
            Refused: The plan cannot be run, or the motion process is gone.
        """
        self._send(Rehearse(plan))
        return self._expect(Certificate, _REHEARSAL_TIMEOUT_S)

    def start(self, plan: Plan, certificate: Certificate) -> None:
        """Start a run; then read ``messages``.

        Raises:
            Refused: The certificate is not that of the plan, the stop is pressed or was not reset, the device
                does not exist, or the motion process is gone.
        """
        self._page.forget_operator()
        self.beat()
        self._send(Start(plan, certificate))
        self._expect(Started, _ANSWER_TIMEOUT_S)
        self._running = True

    def messages(self, timeout_s: float = 10.0) -> Iterator[Message | RunEnd]:
        """Messages of the run as they come, up to its RunEnd. Reading them beats.

        Args:
            timeout_s: Longest silence; a run speaks at least ten times a second.

        Raises:
            Refused: The motion process refused in mid-run, fell silent, or is gone.
        """
        heard = time.monotonic()
        while self._running:
            self.beat()
            message = self._receive(_POLL_S)
            if isinstance(message, _RUN_MESSAGES):
                heard = time.monotonic()
                self._running = not isinstance(message, RunEnd)
                yield message
            elif isinstance(message, Refusal):
                self._running = False
                raise _refused(message)
            elif time.monotonic() - heard > timeout_s:
                raise self._gone(f"silent for {timeout_s:g} s")

    def press_stop(self) -> None:
        """Stop. Takes no lock, waits for nothing; safe from any thread, callback or async route."""
        self._page.press_stop()

    def beat(self) -> None:
        """Show that the app is alive; in real time at least every 250 ms."""
        self._page.beat()

    def operator_beat(self) -> None:
        """Show that the operator's page is alive; from the first call of a run on, silence of 1 s holds."""
        self._page.operator_beat()

    def pause(self) -> None:
        """Come to rest on the path."""
        self._order(Pause())

    def resume(self) -> None:
        """Go on; after a hold and ``reset``, this is the new enable."""
        self._order(Resume())

    def reverse(self) -> None:
        """Go back along the path, to its start at most; ``resume`` goes on again."""
        self._order(Reverse())

    def advance(self) -> None:
        """Go on to the next repetition or posture."""
        self._order(Advance())

    def set_speed(self, speed: float) -> None:
        """Play at this fraction of the therapist's speed, never above the prescribed one.

        Raises:
            Refused: The fraction is not 0.1 to 1, or the motion process is gone.
        """
        self._order(SetSpeed(speed))

    def pain(self) -> None:
        """The patient reports pain: hold, and lower to rest."""
        self._order(Pain())

    def reset(self) -> None:
        """A person who has looked at the patient clears a hold, or after a run the stop.

        Raises:
            Refused: The motion process is gone.
        """
        self._send(Reset())
        if not self._running:
            self._expect(Cleared, _ANSWER_TIMEOUT_S)

    def live(self) -> LiveSample:
        """The newest telemetry; takes no lock."""
        return self._page.read_live()

    def stop_latency_ns(self) -> int | None:
        """From ``press_stop`` to the tick that acted on it, ns; None while there is none."""
        latched = self._page.latched_t_ns
        return latched - self._page.pressed_t_ns if latched else None

    def close(self) -> None:
        """End the motion process; a run that is going on is braked first."""
        if self._closed:
            return
        self._closed = True
        if self._running:
            self._page.press_stop()
        self._wire.close()
        try:
            self._process.wait(_END_TIMEOUT_S)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._page.close()
        self._last_words.close()

    def _spawn(self, theirs: socket.socket) -> subprocess.Popen[bytes]:
        passed = (theirs.fileno(), self._page.descriptor)
        return subprocess.Popen(
            [sys.executable, "-P", "-m", "robot_iface", *(str(descriptor) for descriptor in passed)],
            pass_fds=passed,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=self._last_words,
            start_new_session=True,  # Ctrl-C in a terminal must reach the app, not kill the brake
            env={**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"},
        )

    def _order(self, order: Order) -> None:
        self._send(order)

    def _send(self, message: Any) -> None:
        content = encode(message)
        try:
            with self._sending:
                self._wire.send(content, _ANSWER_TIMEOUT_S)
        except WireClosed as error:
            raise self._gone("gone") from error

    def _receive(self, timeout_s: float) -> Any:
        try:
            content = self._wire.receive(timeout_s)
        except WireClosed as error:
            raise self._gone("gone") from error
        return None if content is None else decode(content)

    def _expect(self, kind: type[Any], timeout_s: float) -> Any:
        """The answer of this kind; what is left of an earlier run is passed over."""
        deadline = time.monotonic() + timeout_s
        while time.monotonic() < deadline:
            self.beat()
            message = self._receive(_POLL_S)
            if isinstance(message, kind):
                return message
            if isinstance(message, Refusal):
                raise _refused(message)
        raise self._gone(f"silent for {timeout_s:g} s")

    def _gone(self, how: str) -> Refused:
        """The refusal that says that the motion process cannot go on, with its last words if it had any."""
        self._running = False
        status = self._process.poll()
        self._last_words.seek(0)
        lines = self._last_words.read().decode(errors="replace").strip().splitlines()
        end = "" if status is None else f", exit status {status}"
        words = f" ({lines[-1][:200]})" if lines else ""
        return Refused(
            "the motion process", how + end + words, "running", "look at the patient and start it again"
        )


def _refused(refusal: Refusal) -> Refused:
    return Refused(refusal.thing, refusal.value, refusal.bound, refusal.remedy)
