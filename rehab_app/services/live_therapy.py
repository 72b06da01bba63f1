"""Plays a therapy session in real time: beats, the operator's watch, the picture, the sealed session."""

from __future__ import annotations

import contextlib
import threading
import time
from collections.abc import Callable

import numpy as np

from rehab_app.access import Account
from rehab_app.services.live_board import Board
from rehab_app.services.replay import COMPARED_PHASES
from rehab_app.services.rows import PreparedPlan
from rehab_app.services.therapy import Therapy, check_accepted
from rehab_app.therapy.run_poses import WornHand
from robot_iface.link import LiveSample, MotionClient
from robot_iface.types import SafetyState

_HELD = (SafetyState.HOLD, SafetyState.COMPLIANT)
_RUNNING = (SafetyState.RAMP_IN, SafetyState.ACTIVE)
_STOPPED = (SafetyState.CAT1, SafetyState.CAT0)
_SUPERVISOR = "the safety supervisor"
BEAT_S = 1.0 / 30.0
OPERATOR_SILENCE_S = 1.0
RESUME_WAIT_S = 3.0


class TherapyJob:
    """One session on its own thread; a second one beats and does nothing else, a third one draws.

    Args:
        board: Where the picture is shown.
        therapy: What rehearses and plays.
        prepared: What is played.
        actor: Who plays it.
        latch: Called with the cause when the supervisor stopped by itself: that too needs a person who looks.
    """

    def __init__(
        self,
        board: Board,
        therapy: Therapy,
        prepared: PreparedPlan,
        actor: Account,
        latch: Callable[[str], None],
    ) -> None:
        self._latch = latch
        self._board = board
        self._therapy = therapy
        self._prepared = prepared
        self._actor = actor
        self._client: MotionClient | None = None
        self._stopped = False
        self._done = threading.Event()
        self._heard_s = time.monotonic()
        self._last_ns = -1
        self._resume_until_s = 0.0
        self._hand = WornHand(prepared.geometry, prepared.plan.joint_names, 0.0)

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
        with MotionClient() as client:
            self._client = client
            try:
                self._run(client)
            finally:
                self._client = None

    def _run(self, client: MotionClient) -> None:
        certificate = self._therapy.rehearse(self._prepared, actor=self._actor, client=client)
        check_accepted(certificate)
        if self._stopped:
            self._board.update(message="Stopped before the robot moved.")
            return
        self._board.update(state="playing", message="Playing.")
        self.hear_operator()
        helpers = [
            threading.Thread(target=work, args=(client,), name=f"live-{name}", daemon=True)
            for name, work in (("beat", self._beat), ("watch", self._watch))
        ]
        for helper in helpers:
            helper.start()
        try:
            result = self._therapy.play(self._prepared, certificate, actor=self._actor, client=client)
        finally:
            self._done.set()
            for helper in helpers:
                helper.join()
        if result.stops and not self._stopped:
            self._latch(f"{_SUPERVISOR}: {result.stops[-1].cause.replace('-', ' ')}")
        words = "The session is recorded." if result.completed else "The session ended early and is recorded."
        self._board.update(state="done", message=words, session_id=result.session, paused=False)

    def _beat(self, client: MotionClient) -> None:
        """Give the sign of life, 30 times a second; no drawing may ever delay it into a stop."""
        while not self._done.wait(BEAT_S):
            client.beat()

    def _watch(self, client: MotionClient) -> None:
        """Draw, 30 times a second, until the run ends."""
        while not self._done.wait(BEAT_S):
            sample = client.live()
            if sample.safety_state in _STOPPED and not self._stopped:
                self._latch(_SUPERVISOR)
            self._say_held(client, sample)
            self._draw(sample)

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
                self._board.update(paused=False, message="Playing.")
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

    def _draw(self, sample: LiveSample) -> None:
        """Publish what the motion process measured since the last picture."""
        if sample.t_ns == self._last_ns or not sample.q_rad.size:
            return
        self._last_ns = sample.t_ns
        patient = self._hand.poses(sample.q_rad[None])
        therapist = self._hand.poses(sample.q_reference_rad[None])
        t_s = sample.t_ns / 1e9
        error_m = None
        if sample.phase in COMPARED_PHASES:
            error_m = np.linalg.norm(patient.fingertips_m[0] - therapist.fingertips_m[0], axis=1)
            self._board.add_error(t_s, float(np.sqrt(np.mean(error_m**2))))
        self._board.picture(
            t_s=t_s,
            therapist_joints_rad=therapist.joints_rad[0],
            patient_joints_rad=patient.joints_rad[0],
            fingertip_error_m=error_m,
            phase=sample.phase,
            repetition=sample.repetition,
            started_by=sample.started_by,
            support=float(np.mean(sample.stiffness_multiple)),
            interaction_nm=float(np.max(np.abs(sample.tau_interaction_nm))),
            safety_state=sample.safety_state.name,
        )
