"""Runs a planned work in real time: beats, the operator's watch, the picture, the sealed session."""

from __future__ import annotations

import contextlib
import gc
import os
import threading
import time
from collections.abc import Callable, Generator

from rehab_app.access import Account
from rehab_app.errors import Refused
from rehab_app.services.live_board import Board
from rehab_app.services.live_picture import RunPicture
from rehab_app.services.live_work import Work, Works
from rehab_app.services.replay import COMPARED_PHASES
from rehab_app.services.snapshot import ALONG
from rehab_app.services.therapy import check_accepted
from rehab_app.therapy.run_causes import sentence_of
from robot_iface.link import LiveSample, MotionClient
from robot_iface.runtime import Message
from robot_iface.types import RunEnd, SafetyEvent, SafetyState

_HELD = (SafetyState.HOLD, SafetyState.COMPLIANT)
_RUNNING = (SafetyState.RAMP_IN, SafetyState.ACTIVE)
_STOPPED = (SafetyState.CAT1, SafetyState.CAT0)
_SUPERVISOR = "the safety supervisor"
BEAT_S = 1.0 / 30.0
OPERATOR_SILENCE_S = 1.0
RESUME_WAIT_S = 3.0
_NOTES = 12
_BEAT_NICE = -10
_SILENT = ("order-refused Resume", "order-refused Reset", "operator-silent", "reset", "repetitions", "sweep")
"""What the page shows in another way, or asks for again by itself."""
GOING = {
    "therapy": "Playing.",
    "range": "Measuring today's range.",
    "fit": "Checking the fit.",
    "tone": "Measuring the tone: the patient lets the hand be moved.",
    "tracking": "The patient follows the target alone: the robot does not help.",
}


@contextlib.contextmanager
def _short_collections() -> Generator[None]:
    """What lives already is not searched for garbage: a full search held the heartbeat up for .2 to .6 s."""
    gc.freeze()
    try:
        yield
    finally:
        gc.unfreeze()


class TherapyJob:
    """One run on its own thread; a second one beats and does nothing else, a third one draws.

    Args:
        board: Where the picture is shown.
        works: What rehearses.
        work: What is run.
        actor: Who runs it.
        latch: Called with the cause when the supervisor stopped by itself: that too needs a person who looks.
    """

    def __init__(
        self,
        board: Board,
        works: Works,
        work: Work,
        actor: Account,
        latch: Callable[[str], None],
    ) -> None:
        self._latch = latch
        self._board = board
        self._works = works
        self._work = work
        self._going = GOING[work.kind]
        self._actor = actor
        self._client: MotionClient | None = None
        self._stopped = False
        self._done = threading.Event()
        self._heard_s = time.monotonic()
        self._resume_until_s = 0.0
        self._said = ""
        self._picture = RunPicture(board, work.prepared)

    def stop(self) -> None:
        """Write the stop word. The flag covers a press before the motion process exists."""
        self._stopped = True
        client = self._client
        if client is not None:
            with contextlib.suppress(ValueError):  # its shared page is gone: the run has just ended
                client.press_stop()

    def finish(self) -> None:
        """Nothing to finish early: a session ends by its prescription or by stop."""

    def hear_operator(self) -> None:
        """The operator's page has spoken; the motion process holds after a second without it."""
        self._heard_s = time.monotonic()
        client = self._client
        if client is not None:
            with contextlib.suppress(ValueError):
                client.operator_beat()

    def pause(self, message: str = "Paused.") -> None:
        """Hold the path."""
        if self._client is not None:
            self._client.pause()
        self._board.update(paused=True, message=message)

    def resume(self) -> None:
        """Go on; out of a hold, a person who is present clears it first and enables anew.

        A hold is cleared only once the hand rests, so the order stands for a few seconds until it does.
        """
        self.hear_operator()
        client = self._client
        if client is not None:
            self._go_on(client)
            self._resume_until_s = time.monotonic() + RESUME_WAIT_S

    def reverse(self) -> None:
        """Go back along the path and wait there; in a sweep, back to the relaxed hand and on from there.

        Raises:
            Refused: The movement is held.
        """
        client = self._client
        if client is None:
            return
        sample = client.live()
        if sample.safety_state not in _RUNNING:
            raise Refused("movement", "held", "not held", "look at the patient and press Resume first")
        client.reverse()
        if self._work.kind not in ALONG or sample.phase == "return":
            return
        if sample.phase in COMPARED_PHASES:
            self._board.update(reversing=True, paused=False, message="Going back. Resume goes on.")
        else:
            self._board.update(paused=True, message="Paused: the movement had not begun.")

    def advance(self) -> None:
        """Go on to what comes next: the end of a rest, the robot's help, the next posture."""
        if self._client is not None:
            self._client.advance()

    @property
    def speed(self) -> float:
        """The path speed that was asked for last."""
        return self._board.snapshot.speed

    def set_speed(self, speed: float) -> None:
        """Ask for another path speed."""
        if self._client is not None:
            self._client.set_speed(speed)
        self._board.update(speed=speed)

    def pain(self) -> None:
        """Pain was entered: the supervisor holds."""
        if self._client is not None:
            self._client.pain()
        self._board.update(paused=True, message="Held: pain was entered. Look at the patient.")

    def run(self) -> None:
        """Rehearse, play, seal.

        Raises:
            Refused: The rehearsal refused the plan, or the motion process failed.
        """
        try:
            with MotionClient() as client:
                self._client = client
                try:
                    self._run(client)
                finally:
                    self._client = None
        finally:
            self._works.end(self._work)

    def _run(self, client: MotionClient) -> None:
        certificate = self._works.rehearse(self._work, self._actor, client)
        check_accepted(certificate)
        if self._stopped:
            self._board.update(message="Stopped before the robot moved.")
            return
        gc.collect()  # while nothing moves yet
        self._board.update(state="playing", message=self._going)
        self.hear_operator()
        helpers = [
            threading.Thread(target=work, args=(client,), name=f"live-{name}", daemon=True)
            for name, work in (("beat", self._beat), ("watch", self._watch))
        ]
        for helper in helpers:
            helper.start()
        try:
            with _short_collections():
                finished = self._work.perform(certificate, client, self._hear)
        finally:
            self._done.set()
            for helper in helpers:
                helper.join()
        for note in finished.notes:
            self._note(note)
        self._board.update(
            state="done",
            message=finished.message,
            session_id=finished.run.session,
            paused=False,
            reversing=False,
        )

    def _hear(self, message: Message | RunEnd) -> None:
        """Note what happened, and who ended it."""
        if isinstance(message, SafetyEvent) and message.cause not in _SILENT:
            self._note(sentence_of(message))
        elif isinstance(message, RunEnd) and message.state in _STOPPED and not self._stopped:
            self._latch(f"{_SUPERVISOR}: {message.reason.replace('-', ' ')}")

    def _note(self, sentence: str) -> None:
        """Show a sentence beneath the others; the same one twice in a row is told once."""
        notes = self._board.snapshot.notes
        if notes[-1:] != (sentence,):
            self._board.update(notes=(*notes, sentence)[-_NOTES:])

    def _beat(self, client: MotionClient) -> None:
        """Give the sign of life, 30 times a second; no drawing may ever delay it into a stop."""
        with contextlib.suppress(OSError):  # where this is not permitted, it keeps the priority of the others
            os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), _BEAT_NICE)
        while not self._done.wait(BEAT_S):
            client.beat()

    def _watch(self, client: MotionClient) -> None:
        """Draw, 30 times a second, until the run ends."""
        while not self._done.wait(BEAT_S):
            sample = client.live()
            if sample.safety_state in _STOPPED and not self._stopped:
                self._latch(_SUPERVISOR)
            self._say_held(client, sample)
            self._say_claim()
            self._picture.draw(sample)

    def _say_claim(self) -> None:
        """Tell once that the claim on the patient was not renewed; nothing else follows from it."""
        said, self._said = self._said, self._works.trouble
        if self._said and self._said != said:
            self._note(self._said)

    def _go_on(self, client: MotionClient) -> None:
        if client.live().safety_state in _HELD:
            client.reset()
        client.resume()

    def _say_held(self, client: MotionClient, sample: LiveSample) -> None:
        """Tell the page whether the path is held, and carry out a resume that waits for the hand to rest."""
        state, paused = sample.safety_state, self._board.snapshot.paused
        if self._resume_until_s:
            if state in _RUNNING:
                self._resume_until_s = 0.0
                self._board.update(paused=False, reversing=False, message=self._going)
            elif time.monotonic() > self._resume_until_s:
                self._resume_until_s = 0.0
                self._board.update(paused=True, message="Still held: wait until the hand rests, then resume.")
            else:
                self._go_on(client)
        elif state in _HELD and not paused:
            silent = time.monotonic() - self._heard_s > OPERATOR_SILENCE_S
            why = "the operator's page fell silent" if silent else "a safety rule asked for it"
            message = f"Held: {why}. Look at the patient, then press Resume."
            self._board.update(paused=True, message=message)
