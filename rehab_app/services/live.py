"""The one live state machine of a clinic: record, rehearse, play, stop.

Thread-safe; blocks no caller but the one who clears a stop.

States::

    idle ─start_recording─▶ countdown ─▶ recording ─▶ processing ─▶ done
    idle ─start_therapy──▶ rehearsing ─▶ playing ─▶ done (so, too, start_assessment)
    any  ─press_stop─────▶ stopped (latched) ─clear_stop─▶ idle
"""

from __future__ import annotations

import secrets
import threading
from dataclasses import replace
from typing import TypeAlias

from rehab_app.access import Account, require
from rehab_app.errors import REFUSALS, Refused
from rehab_app.services.audit import Audit
from rehab_app.services.live_board import Board
from rehab_app.services.live_controls import LiveControls
from rehab_app.services.live_interrupted import Interrupted
from rehab_app.services.live_latch import StopLatch
from rehab_app.services.live_recording import RecordingJob, RecordingOrder
from rehab_app.services.live_target import LiveTarget
from rehab_app.services.live_therapy import TherapyJob
from rehab_app.services.live_work import Work, Works, first_picture
from rehab_app.services.order import PLAIN, Order
from rehab_app.services.patients import side_named
from rehab_app.services.recording_request import PROTOCOL, VIRTUAL, RecordingRequest
from rehab_app.services.snapshot import BUSY, LiveSnapshot
from rehab_app.services.takes import Takes
from sessions.records.fields import Float64

Job: TypeAlias = RecordingJob | TherapyJob


class LiveDesk:
    """What the live page drives. Every verb returns at once; the work happens on the desk's own threads.

    Args:
        takes: Where recordings go.
        works: What plans, rehearses and plays.
        audit: Where every verb is noted.
        interrupted: Restores what a run that broke off had recorded; None to leave that to the next start.

    Attributes:
        controls: The verbs of the run that goes on.
        target: The target grip that the pictures show.
    """

    def __init__(
        self,
        takes: Takes,
        works: Works,
        audit: Audit,
        interrupted: Interrupted | None = None,
    ) -> None:
        self._interrupted = interrupted
        self._takes = takes
        self._works = works
        self._audit = audit
        self.controls = LiveControls(self._run_going_on, audit)
        self.target = LiveTarget(audit)
        self._board = Board()
        self._starting = threading.Lock()
        self._thread: threading.Thread | None = None
        # The next two are used without a lock by press_stop: single attribute accesses.
        self._job: Job | None = None
        self._stop = StopLatch()

    def snapshot(self) -> LiveSnapshot:
        """The newest picture, with the target grip laid over it; waits for nothing."""
        shown, source = self.target.onto(self._board.snapshot), self._stop.source
        if not source:
            return shown
        message = f"Stopped by {source}. Look at the patient, then clear the stop."
        return replace(shown, state="stopped", message=message, stop_source=source)

    def camera_jpeg(self) -> bytes | None:
        """The newest camera image as JPEG, None while no camera runs."""
        return self._board.jpeg

    def error_history(self) -> tuple[Float64, Float64]:
        """RMS fingertip error of the last 30 s: t_s (n,) and error_mm (n,)."""
        return self._board.error_history()

    def start_recording(
        self,
        account: Account,
        exercise: str,
        side: str,
        seconds: float,
        countdown_s: float = 3.0,
        seed: int | None = None,
        *,
        camera: str = VIRTUAL,
        protocol: str = PROTOCOL,
        person: str = "",
        consent_images: bool = False,
    ) -> None:
        """Count down and record in real time, ``seconds`` at most, after ``countdown_s``: see the request.

        Raises:
            Refused: The role may not record, the desk is busy, stop is pressed, or a value is out of bounds.
        """
        require(account, "record")
        request = RecordingRequest(
            exercise=exercise,
            side=side_named(side),
            seconds=seconds,
            camera=camera,
            protocol=protocol,
            person=person,
            consent_images=consent_images,
            seed=secrets.randbelow(2**31) if seed is None else seed,
            realtime=True,
        )
        order = RecordingOrder(account, request, countdown_s)
        with self._starting:
            self._check_free()
            self._board.begin(
                state="countdown",
                message="Get ready: hand open and still.",
                side=request.side,
                countdown_s=countdown_s,
            )
            self._start(RecordingJob(self._board, self._takes, order))

    def finish_recording(self, account: Account) -> None:
        """End the recording now and keep what there is."""
        require(account, "record")
        job = self._job
        if job is not None:
            job.finish()

    def start_therapy(
        self,
        account: Account,
        patient_id: str | None,
        take_id: str,
        order: Order = PLAIN,
        *,
        present: str | None = None,
    ) -> None:
        """Rehearse, then play in real time.

        Args:
            account: Who plays.
            patient_id: Pseudonym of the patient, None for a demonstration.
            take_id: Catalogue id of an approved take.
            order: What is asked for; it is played on the wall clock whatever it says.
            present: Pseudonym of who sits at the robot, as a person confirmed; None where nobody was asked.

        Raises:
            Refused: The role may not play, the desk is busy, stop is pressed, the take is not approved, the
                patient is unknown or in therapy at another station, another one is present, or the
                prescription is out of bounds.
        """
        require(account, "play")
        self._check_free()
        self._begin(account, self._works.plan("therapy", account, patient_id, take_id, order, present))

    def start_assessment(
        self,
        account: Account,
        kind: str,
        patient_id: str | None,
        order: Order = PLAIN,
        *,
        present: str | None = None,
        take_id: str = "",
        arm_posture: str = "",
    ) -> None:
        """Rehearse, then measure ("range", "tone", "tracking") or check the fit ("fit") in real time.

        Args:
            account: Who plays.
            kind: Which.
            patient_id: Pseudonym of the patient.
            order: As of ``start_therapy``.
            present: As of ``start_therapy``.
            take_id: Tracking: catalogue id of the approved take to follow.
            arm_posture: Tone: how arm and shoulder are held, in words.

        Raises:
            Refused: As of ``start_therapy``, nobody is named, the robot is not worn, or the arm's posture is
                not said.
        """
        require(account, "play")
        self._check_free()
        work = self._works.plan(kind, account, patient_id, take_id, order, present, arm_posture)
        self._begin(account, work)

    def press_stop(self, source: str) -> None:
        """Stop. No role, no lock, no database: writes the stop word, then queues the audit row."""
        self._stop.press(source or "unnamed")
        job = self._job
        if job is not None:
            job.stop()
        self._audit.note_later(source or "unnamed", "stop")

    def clear_stop(self, account: Account, confirmed: bool) -> None:
        """Release the latched stop after somebody has looked at the patient.

        Raises:
            Refused: The role may not, it was not confirmed, or as of ``StopLatch.release``, which waits.
        """
        require(account, "clear_stop")
        if not confirmed:
            raise Refused(
                "stop", "latched", "cleared only by someone who looked at the patient", "confirm that you did"
            )
        self._stop.release(self._thread)
        self._board.begin(message="Ready. The stop was cleared.")
        self._audit.note_later(account.name, "clear stop")

    def pain(self, account: Account | None, digit: str = "") -> None:
        """Enter pain, by anyone: the run holds, and the entry is recorded."""
        job = self._run_going_on()
        if job is not None:
            job.pain()
        name = "unnamed" if account is None else account.name
        self._audit.note_later(name, "pain", detail=digit)

    def operator_beat(self) -> None:
        """The operator's page is alive; more than 1 s of silence while playing holds the path."""
        job = self._run_going_on()
        if job is not None:
            job.hear_operator()

    def close(self) -> None:
        """Stop whatever runs and wait until it is sealed."""
        job, thread = self._job, self._thread
        if job is not None:
            job.stop()
        if thread is not None:
            thread.join()

    def _latch(self, cause: str) -> None:
        if self._stop.take(cause):
            self._audit.note_later(cause, "stop")

    def _check_free(self) -> None:
        if self._stop.source:
            raise Refused("stop", "pressed", "cleared", "look at the patient and clear the stop")
        alive = self._thread is not None and self._thread.is_alive()
        if alive or self._board.snapshot.state in BUSY:
            raise Refused(
                "live desk", self._board.snapshot.state, "free", "wait until it is done, or stop it"
            )

    def _run_going_on(self) -> TherapyJob | None:
        job = self._job
        return job if isinstance(job, TherapyJob) else None

    def _begin(self, account: Account, work: Work) -> None:
        with self._starting:
            self._check_free()
            self._works.begin(work)
            self._board.begin(
                state="rehearsing", message="Rehearsing on the virtual twin.", **first_picture(work)
            )
            self._start(TherapyJob(self._board, self._works, work, account, self._latch))
        subject = work.prepared.patient_id or work.prepared.take_id
        self._audit.note_later(account.name, "start", subject, f"{work.kind} on {work.prepared.plan.device}")

    def _start(self, job: Job) -> None:
        self._job = job
        if self._stop.source:  # pressed between the check and here
            job.stop()
        self._thread = threading.Thread(target=self._work, args=(job,), name="live", daemon=True)
        self._thread.start()

    def _work(self, job: Job) -> None:
        """Run a job; whatever ends it, the desk is left in a state that can be read."""
        message = "The work ended unexpectedly; the server's log says why."
        try:
            job.run()
            message = ""
        except REFUSALS as refusal:
            message = str(refusal)
        except OSError as error:
            message = f"The file could not be written: {error.strerror or error}."
        finally:
            self._job = None
            if message:
                self._board.update(state="failed", message=message)
                if self._interrupted is not None:
                    self._interrupted.restore()
